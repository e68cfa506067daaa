// Camera pose T_map_camera: position and unit quaternion.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/core/affine.hpp>
#include <span>

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

/// T_map_camera as a transform: its product with a point in the camera is that point in the map.
inline cv::Affine3d rigidOf(const Pose& p) {
  const double xx = p.qx * p.qx, yy = p.qy * p.qy, zz = p.qz * p.qz;
  const double xy = p.qx * p.qy, xz = p.qx * p.qz, yz = p.qy * p.qz;
  const double wx = p.qw * p.qx, wy = p.qw * p.qy, wz = p.qw * p.qz;
  return {cv::Matx33d(1 - 2 * (yy + zz), 2 * (xy - wz), 2 * (xz + wy),  //
                      2 * (xy + wz), 1 - 2 * (xx + zz), 2 * (yz - wx),  //
                      2 * (xz - wy), 2 * (yz + wx), 1 - 2 * (xx + yy)),
          cv::Vec3d(p.x, p.y, p.z)};
}

/// The inverse of rigidOf(); `transform` must be rigid.
inline Pose poseOf(const cv::Affine3d& transform) {
  const cv::Matx33d r = transform.rotation();
  const cv::Vec3d t = transform.translation();
  // Shepperd 1978: divide by the largest of the four, which is never near 0.
  const double trace = r(0, 0) + r(1, 1) + r(2, 2);
  const double squares[] = {1 + 2 * r(0, 0) - trace, 1 + 2 * r(1, 1) - trace, 1 + 2 * r(2, 2) - trace,
                            1 + trace};
  const auto i = static_cast<int>(std::max_element(squares, squares + 4) - squares);
  const int j = (i + 1) % 3, k = (i + 2) % 3;
  cv::Vec4d q;  // x y z w
  if (i == 3) {
    q = {r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1), squares[3]};
  } else {
    q[i] = squares[i];
    q[j] = r(j, i) + r(i, j);
    q[k] = r(k, i) + r(i, k);
    q[3] = r(k, j) - r(j, k);
  }
  q *= 1 / cv::norm(q);
  return {t[0], t[1], t[2], q[0], q[1], q[2], q[3]};
}

/// The rotation angle of a transform [rad, 0 to π].
inline double angleOf(const cv::Affine3d& transform) {
  const cv::Matx33d r = transform.rotation();
  const double sine = std::sqrt(std::pow(r(2, 1) - r(1, 2), 2) + std::pow(r(0, 2) - r(2, 0), 2) +
                                std::pow(r(1, 0) - r(0, 1), 2));
  return std::atan2(sine, r(0, 0) + r(1, 1) + r(2, 2) - 1);  // small angles, too, unlike the arc cosine
}

/// Position in the floor's plane, and the direction in which the camera looks, counter-clockwise.
struct PlanarPose {
  double x = 0, y = 0, heading = 0;
};

/// To −π … π.
inline double wrapped(double angle) {
  return std::remainder(angle, 2 * std::numbers::pi);
}

/// Motion of the robot between two frames, in the frame of the first one's camera.
struct PlanarMotion {
  double forward = 0, left = 0, turn = 0;
  /// Motion of which only the extent is known: it goes anywhere within about `looseDistance`, `looseTurn`.
  double looseDistance = 0, looseTurn = 0;

  double distance() const { return std::hypot(forward, left); }

  /// This one, then `next`.
  PlanarMotion then(const PlanarMotion& next) const {
    const double c = std::cos(turn), s = std::sin(turn);
    return {forward + c * next.forward - s * next.left, left + s * next.forward + c * next.left,
            wrapped(turn + next.turn), looseDistance + next.looseDistance, looseTurn + next.looseTurn};
  }
};

/// Motion of a robot on its floor. A tilted camera sees the drive forward and the turn tilted, but as long as
/// they are.
inline PlanarMotion motionBetween(const Pose& from, const Pose& to) {
  const cv::Affine3d motion = rigidOf(from).inv() * rigidOf(to);
  const cv::Vec3d t = motion.translation();
  const double flat = std::hypot(t[0], t[2]);
  const double scale = flat > 0 ? cv::norm(t) / flat : 0;
  const cv::Vec3d turn = motion.rvec();  // about x it nods
  return {t[2] * scale, -t[0] * scale, std::copysign(std::hypot(turn[1], turn[2]), -turn[1])};
}

/// The floor of a drive. A robot's camera may look up or down, but it does not roll: its right axis stays in
/// the floor's plane, and where the robot turns, two such axes fix it. Among the remaining directions, up is
/// nearest to the cameras' mean upward direction.
class Floor {
 public:
  explicit Floor(std::span<const Pose> poses) {
    cv::Vec3d up;
    cv::Matx33d rolled = 1e-3 * static_cast<double>(poses.size()) * cv::Matx33d::eye();
    for (const Pose& pose : poses) {
      const cv::Matx33d rotation = rigidOf(pose).rotation();
      const cv::Vec3d right = rotation * cv::Vec3d(1, 0, 0);
      up -= rotation * cv::Vec3d(0, 1, 0);
      rolled += right * right.t();
    }
    *this = Floor(cv::norm(up) < 1e-9 ? cv::Vec3d(0, 0, 1) : rolled.inv() * up);
  }

  /// `up`: a direction in the map, of any length but 0.
  explicit Floor(const cv::Vec3d& up) : up_(cv::normalize(up)) {
    const cv::Vec3d axis = std::abs(up_[0]) < 0.9 ? cv::Vec3d(1, 0, 0) : cv::Vec3d(0, 1, 0);
    right_ = cv::normalize(axis - up_ * axis.dot(up_));
    ahead_ = up_.cross(right_);
  }

  /// Unit length, away from the floor.
  const cv::Vec3d& up() const { return up_; }

  PlanarPose project(const Pose& pose) const {
    const cv::Point2d at = position({pose.x, pose.y, pose.z});
    const auto f = pose.forward();
    const cv::Point2d look = position({f[0], f[1], f[2]});
    return {at.x, at.y, std::atan2(look.y, look.x)};
  }

  /// A point of the map on the floor [m], along the floor's two axes. In a map with z up these are x and y.
  cv::Point2d position(const cv::Vec3d& point) const { return {point.dot(right_), point.dot(ahead_)}; }
  /// The point of the map at a place on the floor's two axes and a height [m].
  cv::Point3d point(const cv::Point3d& place) const {
    return cv::Point3d(right_ * place.x + ahead_ * place.y + up_ * place.z);
  }
  /// The height of a point above the origin of the map [m].
  double height(const cv::Vec3d& point) const { return point.dot(up_); }

 private:
  cv::Vec3d right_, ahead_, up_;
};

}  // namespace estancia
