// Cameras in boxes: depth images of rooms without furniture, computed from planes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "estancia/core/camera.hpp"
#include "estancia/core/pose.hpp"

namespace estancia::test {

inline CameraIntrinsics smallCamera() {
  return {64, 48, 52.5, 52.5, 31.5, 23.5};
}

/// At (x, y, z), looking along `heading` and up by `tilt` [rad]; z is up.
inline Pose lookingAt(double x, double y, double z, double heading, double tilt) {
  const cv::Affine3d level = rigidOf(Pose::planar(x, y, heading));
  const cv::Affine3d tilted(cv::Vec3d(tilt, 0, 0), cv::Vec3d());
  Pose pose = poseOf(level * tilted);
  pose.z = z;
  return pose;
}

/// Where a ray enters and leaves the box between two corners, in lengths of `ray`, from 0 to 100; it misses
/// the box where it would leave first.
inline std::pair<double, double> crossingOf(const cv::Vec3d& low, const cv::Vec3d& high,
                                            const cv::Vec3d& from, const cv::Vec3d& ray) {
  double enter = 0, leave = 100;
  for (int axis = 0; axis < 3; ++axis) {
    const double a = (low[axis] - from[axis]) / ray[axis], b = (high[axis] - from[axis]) / ray[axis];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return {enter, leave};
}

/// Depth [m] inside a room over the rectangle (x, y, width, depth), 2.5 m high.
inline cv::Mat boxDepth(const Pose& pose, const cv::Rect2d& room) {
  const CameraIntrinsics camera = smallCamera();
  const cv::Matx33d rotation = rigidOf(pose).rotation();
  cv::Mat depth(camera.height, camera.width, CV_32F);
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u) {
      const cv::Vec3d ray = rotation * cv::Vec3d(camera.slopeX(u), camera.slopeY(v), 1);
      double nearest = std::numeric_limits<double>::infinity();
      const auto hit = [&](double from, double direction, double low, double high) {
        if (direction != 0) nearest = std::min(nearest, ((direction > 0 ? high : low) - from) / direction);
      };
      hit(pose.x, ray[0], room.x, room.x + room.width);
      hit(pose.y, ray[1], room.y, room.y + room.height);
      hit(pose.z, ray[2], 0, 2.5);
      depth.at<float>(v, u) = static_cast<float>(nearest);
    }
  return depth;
}

/// Boxes from corner to corner [m].
using Boxes = std::vector<std::array<cv::Vec3d, 2>>;

/// Depth [m] in a room of 6 × 6 × 2.5 m around the origin with boxes, which stand at `place`.
inline cv::Mat boxesDepth(const Pose& at, const CameraIntrinsics& camera, const Boxes& boxes,
                          const cv::Affine3d& place = cv::Affine3d::Identity()) {
  const cv::Affine3d pose = rigidOf(at), inBoxes = place.inv() * pose;
  cv::Mat depth(camera.height, camera.width, CV_32F);
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u) {
      const cv::Vec3d ray(camera.slopeX(u), camera.slopeY(v), 1);
      double z = crossingOf({-3, -3, 0}, {3, 3, 2.5}, pose.translation(), pose.rotation() * ray).second;
      for (const auto& [low, high] : boxes) {
        const auto [enter, leave] = crossingOf(low, high, inBoxes.translation(), inBoxes.rotation() * ray);
        if (enter < leave) z = std::min(z, enter);
      }
      depth.at<float>(v, u) = static_cast<float>(z);
    }
  return depth;
}

/// Depth [m] in a flat: rooms over (0, 0, 4, 4) and (5, 0, 4, 4), a corridor over (0, 4.5, 9, 1.4), and doors
/// of 0.9 m from each room to the corridor, all 2.5 m high. Found by walking along each ray in steps.
inline cv::Mat flatDepth(const Pose& pose) {
  static const std::vector<cv::Rect2d> parts{
      {0, 0, 4, 4}, {5, 0, 4, 4}, {0, 4.5, 9, 1.4}, {2, 3.9, 0.9, 0.7}, {6, 3.9, 0.9, 0.7}};
  const CameraIntrinsics camera = smallCamera();
  const cv::Matx33d rotation = rigidOf(pose).rotation();
  cv::Mat depth(camera.height, camera.width, CV_32F);
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u) {
      const cv::Vec3d ray = rotation * cv::Vec3d(camera.slopeX(u), camera.slopeY(v), 1);
      double z = 0;
      for (bool inside = true; inside && z < 8; z += inside ? 0.01 : 0) {
        const cv::Vec3d point = cv::Vec3d(pose.x, pose.y, pose.z) + z * ray;
        inside = point[2] > 0 && point[2] < 2.5 &&
                 std::any_of(parts.begin(), parts.end(), [&](const cv::Rect2d& part) {
                   return part.contains(cv::Point2d(point[0], point[1]));
                 });
      }
      depth.at<float>(v, u) = static_cast<float>(z < 8 ? z : 0);
    }
  return depth;
}

}  // namespace estancia::test
