// SPDX-License-Identifier: Apache-2.0
#include "estancia/query/accuracy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <functional>
#include <map>
#include <numbers>
#include <numeric>
#include <string_view>

#include "estancia/core/fail.hpp"
#include "estancia/files/files.hpp"
#include "estancia/map_file/places.hpp"

namespace estancia {
namespace {

/// A share that is known only once something could be judged.
class Share {
 public:
  void count(bool right) {
    ++judged_;
    right_ += right ? 1U : 0U;
  }
  std::optional<double> value() const {
    if (judged_ == 0) return std::nullopt;
    return static_cast<double>(right_) / static_cast<double>(judged_);
  }

 private:
  std::size_t judged_ = 0, right_ = 0;
};

std::optional<double> medianOf(std::vector<double> values) {
  if (values.empty()) return std::nullopt;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct Judge {
  Share room, recall;
  std::vector<double> errors;

  void judge(const Frame& truth, const MappedFrame& answer, std::size_t answerNumber,
             const std::set<std::size_t>* admissible) {
    if (!truth.room.empty() && !answer.room.empty()) room.count(truth.room == answer.room);
    if (admissible != nullptr) recall.count(admissible->contains(answerNumber));
    if (truth.pose && answer.pose) errors.push_back(distanceBetween(*truth.pose, *answer.pose));
  }
  Accuracy accuracy() { return {room.value(), recall.value(), medianOf(errors)}; }
};

/// The map's frames that were taken near `pose`.
std::set<std::size_t> framesNear(const Pose& pose, const TopologicalMap& map,
                                 const PlaceFilterOptions& near) {
  const double least = std::cos(near.nearAngle * std::numbers::pi / 180);
  const auto ahead = pose.forward();
  std::set<std::size_t> views;
  for (std::size_t i = 0; i < map.frames.size(); ++i) {
    const auto& other = map.frames[i].pose;
    if (!other || distanceBetween(pose, *other) > near.nearDistance) continue;
    const auto look = other->forward();
    if (std::inner_product(ahead.begin(), ahead.end(), look.begin(), 0.0) >= least) views.insert(i);
  }
  return views;
}

/// The true room of most of each zone's frames, where any is known.
std::map<int, std::string> roomsOf(const std::vector<int>& zoneOf, const TopologicalMap& map) {
  std::map<int, std::map<std::string, std::size_t>> counts;
  for (std::size_t i = 0; i < zoneOf.size(); ++i)
    if (const std::string& room = map.frames.at(i).room; !room.empty() && zoneOf[i] >= 0)
      ++counts[zoneOf[i]][room];
  std::map<int, std::string> rooms;
  for (const auto& [zone, count] : counts)
    rooms[zone] = std::max_element(count.begin(), count.end(), [](const auto& a, const auto& b) {
                    return a.second < b.second;
                  })->first;
  return rooms;
}

std::optional<std::size_t> parseNumber(std::string_view text) {
  std::size_t value = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (problem != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

AdmissibleImages readAdmissibleImages(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string line;
  if (!std::getline(file, line))
    throw Error(ErrorCode::fileUnreadable, path.string() + ": cannot be read, or is empty");
  AdmissibleImages admissible;
  for (std::size_t number = 2; std::getline(file, line); ++number) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty()) continue;
    const auto complain = [&]() -> Error {
      return Error(
          ErrorCode::malformedFile,
          fmt::format("{}:{}: expected \"{},FRAME FRAME …\" with frame numbers of the map, found \"{}\"",
                      path.string(), number, admissible.size(), line.substr(0, 80)));
    };
    const auto comma = line.find(',');
    if (comma == std::string::npos ||
        parseNumber(std::string_view(line).substr(0, comma)) != admissible.size())
      throw complain();
    std::set<std::size_t> frames;
    for (const std::string_view word : io::wordsOf(std::string_view(line).substr(comma + 1))) {
      const auto frame = parseNumber(word);
      if (!frame) throw complain();
      frames.insert(*frame);
    }
    admissible.push_back(std::move(frames));
  }
  return admissible;
}

LocalizationSummary summarizeLocalization(std::span<const Localization> answers) {
  LocalizationSummary summary;
  std::map<int, std::vector<double>> confidences;
  std::vector<double> all;
  Share unmapped;
  for (const Localization& answer : answers) {
    confidences[answer.beliefNode].push_back(answer.confidence);
    all.push_back(answer.confidence);
    if (answer.unmapped) unmapped.count(*answer.unmapped > 0.5);
  }
  for (const auto& [node, values] : confidences)
    summary.places.push_back({node, values.size(), *medianOf(values)});
  std::ranges::stable_sort(summary.places, std::ranges::greater{}, &LocalizationSummary::Place::frames);
  summary.medianConfidence = medianOf(std::move(all));
  summary.unmapped = unmapped.value();
  return summary;
}

LocalizationAccuracy measureLocalization(const TopologicalMap& map, const std::vector<Frame>& frames,
                                         const std::vector<std::size_t>& numbers,
                                         const std::vector<Localization>& answers,
                                         const AdmissibleImages& admissible, const PlaceFilterOptions& near,
                                         const std::vector<int>& zoneOf) {
  if (frames.size() != answers.size() || frames.size() != numbers.size())
    throw Error(ErrorCode::mismatch, "localization can only be measured with one answer for each frame");
  const std::vector<Place> places = placesOf(map);
  const auto roomOf = [&](int node) -> const std::string& { return places.at(indexOf(map, node)).room; };
  Judge nearest, belief;
  const std::map<int, std::string> roomOfZone = roomsOf(zoneOf, map);
  Share nodeRoom, beliefNodeRoom, beliefZoneRoom;
  std::size_t judged = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const std::set<std::size_t>* right = nullptr;
    std::set<std::size_t> nearOnes;
    if (admissible.empty() && frames[i].pose) {
      nearOnes = framesNear(*frames[i].pose, map, near);
      if (!nearOnes.empty()) right = &nearOnes;
    }
    if (!admissible.empty()) {
      if (numbers[i] >= admissible.size())
        fail(ErrorCode::mismatch,
             "the truth ends at frame {}, but the sequence has a frame {}; is it the truth of "
             "another sequence?",
             admissible.size() - 1, numbers[i]);
      right = &admissible[numbers[i]];
    }
    judged += right != nullptr ? 1 : 0;
    const Localization& answer = answers[i];
    nearest.judge(frames[i], map.frames.at(answer.nearestImage), answer.nearestImage, right);
    belief.judge(frames[i], map.frames.at(answer.beliefImage), answer.beliefImage, right);
    if (frames[i].room.empty()) continue;
    if (const std::string& room = roomOf(answer.node); !room.empty()) nodeRoom.count(room == frames[i].room);
    if (const std::string& room = roomOf(answer.beliefNode); !room.empty())
      beliefNodeRoom.count(room == frames[i].room);
    if (answer.beliefZone)
      if (const auto zone = roomOfZone.find(*answer.beliefZone); zone != roomOfZone.end())
        beliefZoneRoom.count(zone->second == frames[i].room);
  }
  return {frames.size(),
          nearest.accuracy(),
          belief.accuracy(),
          nodeRoom.value(),
          beliefNodeRoom.value(),
          beliefZoneRoom.value(),
          judged};
}

}  // namespace estancia
