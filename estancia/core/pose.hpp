// Camera pose T_map_camera: position and unit quaternion.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>

namespace estancia {

/// T_map_camera: the camera's optical frame (x right, y down, z forward; REP-103) in the map. Meters. A
/// robot's planar pose (x, y, θ) becomes a camera that looks along θ in a z-up map.
struct Pose {
  /// Position in the map [m].
  double x = 0, y = 0, z = 0;
  /// Unit quaternion, rotation map ← camera.
  double qx = 0, qy = 0, qz = 0, qw = 1;

  /// A level camera at (x, y, 0) that looks along `theta` (radians, counter-clockwise from the map's x axis).
  static Pose planar(double x, double y, double theta) {
    // R = Rz(theta) · R_body_optical, with R_body_optical = (qx, qy, qz, qw) = (-½, ½, -½, ½)
    const double c = 0.5 * std::cos(theta / 2), s = 0.5 * std::sin(theta / 2);
    return {x, y, 0, -c - s, c - s, -c + s, c + s};
  }

  /// The viewing direction (the optical z axis) as a unit vector in the map.
  std::array<double, 3> forward() const {
    return {2 * (qx * qz + qw * qy), 2 * (qy * qz - qw * qx), 1 - 2 * (qx * qx + qy * qy)};
  }

  /// Whether it can be a camera's: all numbers are finite, and the position is within 10 000 km of the
  /// origin, as in all maps of the Earth; what lies beyond is an error of a trajectory.
  bool isPlausible() const {
    constexpr double limit = 1e7;
    return std::abs(x) < limit && std::abs(y) < limit && std::abs(z) < limit && std::isfinite(qx) &&
           std::isfinite(qy) && std::isfinite(qz) && std::isfinite(qw);
  }
};

inline double distanceBetween(const Pose& a, const Pose& b) {
  return std::hypot(a.x - b.x, a.y - b.y, a.z - b.z);
}

}  // namespace estancia
