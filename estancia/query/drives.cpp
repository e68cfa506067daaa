// SPDX-License-Identifier: Apache-2.0
#include "estancia/query/drives.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

namespace estancia {
namespace {

/// `known`: places of the drives before; `joinedAfter`: the frame after which a place joined another.
DriveSummary summarize(const TopologicalMap& map, std::size_t number,
                       const std::map<int, std::size_t>& joinedAfter, std::set<int>& known) {
  const std::size_t begin = map.drives[number].firstFrame;
  const std::size_t end =
      number + 1 < map.drives.size() ? map.drives[number + 1].firstFrame : map.frames.size();
  DriveSummary summary;
  summary.drive = map.drives[number];
  const auto numberOf = [&map](std::size_t i) {
    return i < map.frames.size() ? map.frames[i].number : map.frames.back().number + 1;
  };
  summary.first = numberOf(begin);
  summary.frames = numberOf(end) - numberOf(begin);
  summary.kept = end - begin;
  std::set<int> seen;
  for (std::size_t i = begin; i < end; ++i) {
    const MappedFrame& frame = map.frames[i];
    seen.insert(frame.node);
    if (frame.pose) ++summary.posed;
    if (frame.timestamp) {
      summary.begins = std::min(summary.begins.value_or(*frame.timestamp), *frame.timestamp);
      summary.ends = std::max(summary.ends.value_or(*frame.timestamp), *frame.timestamp);
    }
    // The node of that time, or of a merge of maps: a place recognized later in the drive may have absorbed
    // it.
    const int then = i < map.decisions.size() ? map.decisions[i].node : frame.node;
    const auto joined = then == frame.node ? joinedAfter.end() : joinedAfter.find(then);
    const bool wasKnown = then == frame.node || (joined != joinedAfter.end() && joined->second + 1 >= end);
    if (!summary.recognized && number > 0 && known.contains(frame.node) && wasKnown)
      summary.recognized = {numberOf(i) - numberOf(begin), frame.node};
  }
  summary.places = seen.size();
  summary.newPlaces =
      static_cast<std::size_t>(std::ranges::count_if(seen, [&](int node) { return !known.contains(node); }));
  known.insert(seen.begin(), seen.end());
  return summary;
}

}  // namespace

std::string describeDrive(const TopologicalMap& map, std::size_t drive) {
  const std::string& name = map.drives[drive].name;
  return name.empty() ? fmt::format("drive {}", drive) : fmt::format("drive {} ({})", drive, name);
}

std::vector<DriveSummary> summarizeDrives(const TopologicalMap& map) {
  std::vector<DriveSummary> drives;
  std::set<int> known;
  std::map<int, std::size_t> joinedAfter;
  for (const Merge& merge : map.merges) joinedAfter[merge.absorbed] = merge.frame;
  for (std::size_t i = 0; i < map.drives.size(); ++i) drives.push_back(summarize(map, i, joinedAfter, known));
  return drives;
}

}  // namespace estancia
