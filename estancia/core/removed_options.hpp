// Removed options: what holds instead of those that have gone, for messages and for files that name them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace estancia {

struct RemovedOption {
  /// Its group and its name, "odometry.max-gap", or a group and the one around it, "scene-filter.gng".
  std::string_view path;
  /// The value that always holds now, as Option::text() wrote it; "" for groups and if there are several.
  std::string_view value;
  /// The end of a sentence; "" where the value needs no advice.
  std::string_view instead;
};

std::span<const RemovedOption> removedOptions();

/// By a path that holds its own, with dashes or underscores: "world.odometry.max_gap". Null for others.
const RemovedOption* findRemovedOption(std::string_view path);

/// "world.odometry.max-gap has gone: it is always 1".
std::string describeRemoved(const RemovedOption& option, std::string_view path);
/// With the value that a map was made with: "…, and was 2 when the map was made".
std::string describeRemoved(const RemovedOption& option, std::string_view path, std::string_view kept);

}  // namespace estancia
