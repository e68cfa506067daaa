// SPDX-License-Identifier: Apache-2.0
#include "estancia/classify/predict_rooms.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <unordered_map>

#include "estancia/classify/embedding.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/describe/table_features.hpp"
#include "estancia/files/csv.hpp"

namespace estancia {
namespace {

std::unordered_map<std::string_view, std::size_t> placesOf(const std::vector<Frame>& frames) {
  std::unordered_map<std::string_view, std::size_t> places;
  for (std::size_t i = 0; i < frames.size(); ++i) places.emplace(frames[i].name, i);
  return places;
}

/// The frames that `left` and `right` share, with the parts of both.
Features joined(const Features& left, const Features& right) {
  Features both{left.parts, {}, DescriptorMatrix(left.values.labels() + right.values.labels())};
  both.parts.insert(both.parts.end(), right.parts.begin(), right.parts.end());
  const auto places = placesOf(right.frames);
  std::vector<float> row;
  for (std::size_t i = 0; i < left.frames.size(); ++i) {
    const auto found = places.find(left.frames[i].name);
    if (found == places.end()) continue;
    const DescriptorView first = left.values.row(i), second = right.values.row(found->second);
    row.assign(first.begin(), first.end());
    row.insert(row.end(), second.begin(), second.end());
    both.frames.push_back(left.frames[i]);
    both.values.append(row);
  }
  return both;
}

}  // namespace

std::string descriptorOf(const RoomClassifier& classifier) {
  std::string all;
  for (const PartEmbedding& learned : classifier.embedding().parts())
    all += (all.empty() ? "" : "+") + learned.part.name;
  return all;
}

std::string nameOf(const RoomClassifier& classifier) {
  return fmt::format("{} on {}", classifier.classifier().type(), descriptorOf(classifier));
}

void requireDescribable(const RoomClassifier& classifier) {
  for (const PartEmbedding& learned : classifier.embedding().parts()) {
    const std::string& name = learned.part.name;
    if (isOfTable(learned.part))
      fail(ErrorCode::mismatch,
           "the room classifier was trained on {} {} of a table; give a table with the same columns, or "
           "train on images",
           learned.part.size() == 1 ? "the column" : "the columns", name);
    if (findDescriptor(name)) continue;
    try {
      getModelFolder(name);
    } catch (const Error& e) {
      fail(e.code(),
           "the room classifier was trained on {}: {}; install it by `estancia models get {}` or `estancia "
           "models add FOLDER`, or give its labels (`*.labels` …) instead of images",
           name, e.what(), name);
    }
  }
}

void requireDescribable(const RoomClassifier& classifier, const Sequence& sequence) {
  requireDescribable(classifier);
  for (const PartEmbedding& learned : classifier.embedding().parts()) {
    const auto descriptor = findDescriptor(learned.part.name);
    if (!descriptor || !descriptor->needsDepth()) continue;
    if (!sequence.hasDepth())
      fail(ErrorCode::invalidInput,
           "{} has no depth, which the room classifier's {} needs; give one that was trained on other "
           "descriptors",
           sequence.name(), learned.part.name);
    if (!sequence.intrinsics())
      fail(ErrorCode::invalidInput,
           "{} has no depth camera, which the room classifier's {} needs; give its intrinsics",
           sequence.name(), learned.part.name);
  }
}

void requireParts(const RoomClassifier& classifier, const std::vector<DescriptorPart>& parts) {
  for (const PartEmbedding& learned : classifier.embedding().parts())
    if (std::ranges::none_of(parts, [&](const DescriptorPart& part) {
          return part.name == learned.part.name && part.identity == learned.part.identity;
        }))
      fail(ErrorCode::mismatch,
           "the room classifier needs {} ({}), which is not among these labels; give the images instead, or "
           "a classifier that was trained on such labels",
           learned.part.name, learned.part.identity);
}

RoomPredictions predictRooms(const RoomClassifier& classifier, const Features& features,
                             const std::vector<Frame>& frames, int threads) {
  const std::size_t rooms = classifier.rooms().size();
  const DescriptorMatrix probabilities = classifier.predict(features, threads);
  const auto places = placesOf(features.frames);
  RoomPredictions predictions{nameOf(classifier), classifier.rooms(), DescriptorMatrix(rooms)};
  predictions.probabilities.reserve(frames.size());
  const std::vector<float> nothing(rooms, 0);
  for (const Frame& frame : frames) {
    const auto found = places.find(frame.name);
    predictions.probabilities.append(found == places.end() ? DescriptorView(nothing)
                                                           : probabilities.row(found->second));
  }
  return predictions;
}

Features featuresFor(const RoomClassifier& classifier, const DescriptorSequence& labels,
                     const Sequence* sequence, const DescribeOptions& options, Progress& progress,
                     std::vector<std::string>* problems) {
  const Features known = featuresOf(labels);
  std::vector<std::string> taken, missing;
  bool differs = false;  // a part of the same name is another
  for (const PartEmbedding& learned : classifier.embedding().parts()) {
    const auto found = std::ranges::find(known.parts, learned.part.name, &DescriptorPart::name);
    const bool same = found != known.parts.end() && found->identity == learned.part.identity;
    differs = differs || (found != known.parts.end() && !same);
    (same ? taken : missing).push_back(learned.part.name);
  }
  if (missing.empty() || (sequence == nullptr && differs)) return known;  // predict() reports the difference
  if (sequence == nullptr)
    fail(ErrorCode::mismatch,
         "the room classifier needs {}, which is not among these labels; give the images, too",
         fmt::join(missing, "+"));
  Features described =
      describeSequence(*sequence, fmt::format("{}", fmt::join(missing, "+")), options, progress, problems);
  Features both = taken.empty() ? std::move(described) : joined(withParts(known, taken), described);
  if (both.frames.empty())
    fail(ErrorCode::mismatch, "{} has none of the labeled images; give those that were labeled",
         sequence->name());
  return both;
}

nlohmann::ordered_json predictionJson(const RoomPredictions& predictions, const std::vector<Frame>& frames,
                                      std::size_t i, double minProbability) {
  const auto rooms = rankedRooms(predictions, i);
  nlohmann::ordered_json json{{"image", frames[i].name},
                              {"room", nullptr},
                              {"probability", nullptr},
                              {"rooms", nlohmann::ordered_json::object()}};
  if (rooms.empty()) return json;
  if (rooms.front().probability >= minProbability) json["room"] = rooms.front().room;
  json["probability"] = rooms.front().probability;
  for (const auto& [room, probability] : rooms) json["rooms"][room] = probability;
  return json;
}

std::string predictionsCsv(const RoomPredictions& predictions, const std::vector<Frame>& frames,
                           double minProbability) {
  std::string text(predictionsCsvHeader);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto rooms = rankedRooms(predictions, i);
    const bool sure = !rooms.empty() && rooms.front().probability >= minProbability;
    text += io::csvCell(frames[i].name) + ',' + (sure ? io::csvCell(rooms.front().room) : "");
    for (std::size_t r = 0; r < 2; ++r) {
      if (r == 1) text += ',' + (rooms.size() > 1 ? io::csvCell(rooms[1].room) : "");
      text += ',' + (r < rooms.size() ? fmt::format("{:.6f}", rooms[r].probability) : "");
    }
    text += '\n';
  }
  return text;
}

// ---- test

std::size_t Confusion::total() const {
  std::size_t sum = 0;
  for (const auto& row : counts)
    for (const std::size_t count : row) sum += count;
  return sum;
}

double Confusion::accuracy() const {
  std::size_t right = 0;
  for (std::size_t r = 0; r < counts.size(); ++r) right += counts[r][r];
  return static_cast<double>(right) / static_cast<double>(total());
}

double Confusion::balancedAccuracy() const {
  double shares = 0;
  std::size_t known = 0;
  for (std::size_t r = 0; r < counts.size(); ++r) {
    std::size_t sum = 0;
    for (const std::size_t count : counts[r]) sum += count;
    if (sum == 0) continue;
    ++known;
    shares += static_cast<double>(counts[r][r]) / static_cast<double>(sum);
  }
  return shares / static_cast<double>(known);
}

Confusion confusionOf(const std::vector<std::string>& truth, const std::vector<std::string>& predicted) {
  if (truth.size() != predicted.size() || truth.empty())
    fail(ErrorCode::mismatch, "there are {} predictions and {} true rooms; give one of each an image",
         predicted.size(), truth.size());
  Confusion confusion{truth, {}};
  auto& rooms = confusion.rooms;
  rooms.insert(rooms.end(), predicted.begin(), predicted.end());
  std::sort(rooms.begin(), rooms.end());
  rooms.erase(std::unique(rooms.begin(), rooms.end()), rooms.end());
  confusion.counts.assign(rooms.size(), std::vector<std::size_t>(rooms.size()));
  const auto indexOf = [&](const std::string& room) {
    return static_cast<std::size_t>(std::lower_bound(rooms.begin(), rooms.end(), room) - rooms.begin());
  };
  for (std::size_t i = 0; i < truth.size(); ++i) ++confusion.counts[indexOf(truth[i])][indexOf(predicted[i])];
  return confusion;
}

std::vector<std::string> mostProbable(const std::vector<std::string>& rooms,
                                      const DescriptorMatrix& probabilities) {
  std::vector<std::string> best;
  for (std::size_t i = 0; i < probabilities.size(); ++i) {
    const DescriptorView row = probabilities.row(i);
    best.push_back(rooms[static_cast<std::size_t>(std::max_element(row.begin(), row.end()) - row.begin())]);
  }
  return best;
}

Confusion testRooms(const RoomClassifier& classifier, const Features& features, int threads) {
  std::vector<std::string> truth, predicted;
  const std::vector<std::string> all =
      mostProbable(classifier.rooms(), classifier.predict(features, threads));
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (features.frames[i].room.empty()) continue;
    truth.push_back(features.frames[i].room);
    predicted.push_back(all[i]);
  }
  if (truth.empty())
    throw Error(ErrorCode::insufficientData,
                "no image has a known room; give a table of rooms (--rooms), or a folder of images per room "
                "(--type classes)");
  return confusionOf(truth, predicted);
}

}  // namespace estancia
