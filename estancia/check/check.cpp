// SPDX-License-Identifier: Apache-2.0
#include "estancia/check/check.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "estancia/check/checklist.hpp"
#include "estancia/core/printable.hpp"

namespace estancia {
namespace check {

std::string share(std::size_t count, std::size_t of, const char* what) {
  return fmt::format("{} of {} {}", count, of, what);
}

double medianOf(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::optional<double> frameInterval(const Sequence& sequence) {
  std::vector<double> intervals;
  for (std::size_t i = 1; i < sequence.size(); ++i)
    if (const auto from = sequence.frame(i - 1).timestamp, to = sequence.frame(i).timestamp;
        from && to && *to > *from)
      intervals.push_back(*to - *from);
  return intervals.empty() ? std::nullopt : std::optional(medianOf(std::move(intervals)));
}

std::vector<std::size_t> evenly(std::size_t size, std::size_t count) {
  count = std::min(count, size);
  std::vector<std::size_t> indices;
  for (std::size_t k = 0; k < count; ++k)  // from the first to the last
    indices.push_back(count == 1 ? 0 : k * (size - 1) / (count - 1));
  return indices;
}

namespace {

/// The images of each room (thesis Fig. 1.3).
void countRooms(const Sequence& sequence, Checklist& list) {
  std::map<std::string, std::size_t> images;
  for (std::size_t i = 0; i < sequence.size(); ++i) ++images[sequence.frame(i).room];
  const std::size_t unknown = images.contains("") ? images.at("") : 0;
  images.erase("");
  if (images.empty()) return;
  const std::size_t shown = std::min<std::size_t>(images.size(), 30);
  std::vector<std::string> rooms;
  for (const auto& [room, count] : images)
    if (rooms.size() < shown) rooms.push_back(fmt::format("{} {}", printable(room), count));
  if (images.size() > shown) rooms.push_back(fmt::format("{} more", images.size() - shown));
  list.fine("rooms", "The rooms of images are known",
            fmt::format("{}; of {} images{}", fmt::join(rooms, ", "), sequence.size(),
                        unknown > 0 ? fmt::format(", {} without", unknown) : ""));
}

}  // namespace
}  // namespace check

std::size_t CheckReport::count(Severity severity) const {
  return static_cast<std::size_t>(std::ranges::count(items, severity, &CheckItem::severity));
}

OptionGroup declare(CheckOptions& o) {
  OptionGroup group("check", "Check of a sequence.");
  group.add("max-frames", &o.maxFrames, "Largest number of frames that are checked, evenly spread")
      .range(1)
      .why("More take longer and find rarer faults.");
  return group;
}

CheckReport checkSequence(const Sequence& sequence, const CheckOptions& options, Progress& progress) {
  validate(options);
  check::Checklist list;
  const check::DepthFacts facts = check::checkImages(sequence, options, progress, list);
  check::checkCamera(sequence, facts, list);
  check::checkTimes(sequence, list);
  check::checkTrajectory(sequence, list);
  check::checkGeometry(sequence, facts, progress, list);
  check::countRooms(sequence, list);
  return {list.take(), sequence.size()};
}

}  // namespace estancia
