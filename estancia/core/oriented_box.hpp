// Oriented box: an upright box that is turned about the vertical axis.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/types.hpp>
#include <span>

namespace estancia {

struct OrientedBox {
  /// Its middle [m]; z is up.
  cv::Point3d center = {};
  /// Before it is turned [m].
  cv::Point3d size = {};
  /// Turn about z, counter-clockwise [rad].
  double yaw = 0;

  double volume() const { return size.x * size.y * size.z; }
};

/// Intersection over union of the volumes; 0 where one has none.
double intersectionOverUnion(const OrientedBox& a, const OrientedBox& b);

/// The upright box of least floor area that holds the points [m] but for the share `trim` at each end of each
/// axis, at least `thickness` wide. Directions: each 2°. Throws Error (invalidInput) without points.
OrientedBox fitBox(std::span<const cv::Point3d> points, double trim, double thickness);

}  // namespace estancia
