// Ground plane: the plane in which poses are shown, and the driven path in it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "estancia/core/pose.hpp"
#include "estancia/figures/svg.hpp"

namespace estancia::report {

/// An orthonormal pair of axes that turns positions of the map [m] into the page's plane (x right, y up).
struct GroundPlane {
  std::array<double, 3> right{1, 0, 0}, up{0, 1, 0};

  Point project(const std::array<double, 3>& position) const;
};

/// The plane that shows a set of positions best. A map whose positions spread least along one of its axes is
/// seen along that axis and keeps its orientation: from above in z-up maps (x right, y up), and, in maps that
/// hang on a first camera (y down), with x right and z up. Otherwise the plane of largest spread (PCA).
GroundPlane planeOf(const std::vector<std::array<double, 3>>& positions);

/// One point a pose in the map's plane [m], y up; none where the pose is unknown, not finite, or so far off
/// that it is an error of the trajectory.
struct DrivenPath {
  std::vector<std::optional<Point>> points;
  GroundPlane plane;
  bool empty = true;  ///< no pose is known
};
/// `fromAbove` uses x and y whatever their spread, as a floor plan needs it.
DrivenPath projectPath(std::span<const std::optional<Pose>> poses, bool fromAbove = false);

}  // namespace estancia::report
