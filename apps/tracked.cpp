// SPDX-License-Identifier: Apache-2.0
#include "tracked.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

namespace estancia::apps {

void warnOfUntracked(const RgbdTrajectory& trajectory, const FrameName& name, const std::string& bridge) {
  constexpr std::size_t shown = 5;
  for (std::size_t i = 0; i < std::min(shown, trajectory.notes.size()); ++i)
    spdlog::warn("{}", trajectory.notes[i]);
  if (trajectory.notes.size() > shown)
    spdlog::warn("{} such notes in all; --json lists them", trajectory.notes.size());
  const auto warn = [&](const std::vector<RgbdTrajectory::Untracked>& frames, const std::string& what) {
    for (std::size_t i = 0; i < std::min(shown, frames.size()); ++i)
      spdlog::warn("{} {}: {}", what, name(frames[i].frame), frames[i].why);
    if (frames.size() > shown) spdlog::warn("{} {} frames in all; --json lists them", what, frames.size());
  };
  warn(trajectory.lost, "no pose for");
  warn(trajectory.bridged, bridge + " bridges");
}

void addCounts(nlohmann::ordered_json& json, const RgbdTrajectory& trajectory) {
  json["placed"] = trajectory.poses.size() - trajectory.lost.size();
  json["keyframes"] = trajectory.keyframes.size();
  json["loops"] = trajectory.loops.size();
  json["corrections"] = trajectory.corrections;
}

void addUntracked(nlohmann::ordered_json& json, const RgbdTrajectory& trajectory, const FrameName& name) {
  for (const auto& [frame, why] : trajectory.lost)
    json["lost"].push_back({{"frame", name(frame)}, {"why", why}});
  for (const auto& [frame, why] : trajectory.bridged)
    json["bridged"].push_back({{"frame", name(frame)}, {"why", why}});
  if (!trajectory.notes.empty()) json["notes"] = trajectory.notes;
}

}  // namespace estancia::apps
