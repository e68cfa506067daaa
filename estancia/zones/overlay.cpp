// SPDX-License-Identifier: Apache-2.0
#include "estancia/zones/overlay.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>
#include <unordered_map>

#include "estancia/core/fail.hpp"

namespace estancia {

bool areOfSameRun(const Zones& zones, const GroupedRun& run) {
  if (!(zones.vocabulary == run.vocabulary)) return true;
  const std::vector<float> ofZones = runMean(zones);
  double difference = 0, sum = 0;
  for (std::size_t i = 0; i < ofZones.size(); ++i) {
    difference += std::abs(static_cast<double>(ofZones[i]) - static_cast<double>(run.mean[i]));
    sum += static_cast<double>(ofZones[i]);
  }
  // A map may give less weight to images on the way between places. Two drives through one corridor differ by
  // .3 of all probability.
  return difference <= 0.15 * sum;
}

std::vector<GroupZones> overlayZones(const Zones& zones, const GroupedRun& run) {
  const auto refuse = [](const std::string& how) {
    fail(ErrorCode::mismatch,
         "the zones are of another run than the map ({}); make them of the map by `estancia zones find MAP "
         "-o FILE`",
         how);
  };
  if (run.frames.size() != zones.frames.size())
    refuse(fmt::format("{} frames, the map has {}", zones.frames.size(), run.frames.size()));
  std::unordered_map<std::string_view, std::size_t> byName;
  for (std::size_t i = 0; i < zones.frames.size(); ++i) byName.emplace(zones.frames[i].name, i);
  std::map<int, std::map<int, std::size_t>> counts;
  for (const auto& frame : run.frames) {
    const auto found = byName.find(frame.name);
    if (found == byName.end()) refuse(fmt::format("it has no frame \"{}\"", frame.name));
    ++counts[frame.group][zones.zoneOf[found->second]];
  }
  if (!areOfSameRun(zones, run)) refuse("the frames have the same names, but other labels");
  std::vector<GroupZones> groups;
  for (const auto& [group, shares] : counts) {
    GroupZones& entry = groups.emplace_back();
    entry.group = group;
    for (const auto& [zone, count] : shares) {
      entry.shares.push_back({zone, count});
      entry.frames += count;
    }
    std::stable_sort(entry.shares.begin(), entry.shares.end(),
                     [](const auto& a, const auto& b) { return a.frames > b.frames; });
  }
  return groups;
}

const GroupZones* findGroup(std::span<const GroupZones> groups, int group) {
  const auto found = std::lower_bound(groups.begin(), groups.end(), group,
                                      [](const GroupZones& g, int number) { return g.group < number; });
  return found != groups.end() && found->group == group ? &*found : nullptr;
}

}  // namespace estancia
