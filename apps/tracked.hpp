// Tracked camera: a command's output about poses by RGB-D odometry.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "estancia/odometry/rgbd.hpp"

namespace estancia::apps {

using FrameName = std::function<std::string(std::size_t frame)>;

/// Warns of time gaps and of the first frames that were not tracked. `bridge`: what gives such frames a pose.
void warnOfUntracked(const RgbdTrajectory& trajectory, const FrameName& name, const std::string& bridge);

/// Adds how many frames were placed, keyframes, loops and corrections.
void addCounts(nlohmann::ordered_json& json, const RgbdTrajectory& trajectory);

/// Adds frames that were not tracked, and notes, where there are some.
void addUntracked(nlohmann::ordered_json& json, const RgbdTrajectory& trajectory, const FrameName& name);

}  // namespace estancia::apps
