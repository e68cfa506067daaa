// Planar pose: poses and motions of a robot on its floor, in meters and radians.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <span>

#include "estancia/core/pose.hpp"
#include "estancia/core/rigid.hpp"

namespace estancia {

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
/// the floor's plane, and where the robot turns, two such axes fix it. Among the directions that remain
/// possible, up is the one nearest to the cameras' mean upward direction.
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
