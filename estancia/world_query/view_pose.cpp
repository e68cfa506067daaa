// SPDX-License-Identifier: Apache-2.0
#include "estancia/world_query/view_pose.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace estancia {
namespace {

/// Half of the object's extent over the floor [m].
double reachOf(const WorldObject& object) {
  return std::hypot(object.size.x, object.size.y) / 2;
}

/// Between where the camera looks and the object's middle [rad].
double angleTo(const WorldObject& object, const Pose& pose) {
  const auto forward = pose.forward();
  const cv::Point3d look(forward[0], forward[1], forward[2]);
  const cv::Point3d ray = object.center - cv::Point3d(pose.x, pose.y, pose.z);
  const double length = std::sqrt(ray.dot(ray));
  return length > 0 ? std::acos(std::clamp(ray.dot(look) / length, -1.0, 1.0)) : 0;
}

}  // namespace

ViewPoses::ViewPoses(const WorldMap& world, double viewAngle)
    : world_(world), viewAngle_(viewAngle * std::numbers::pi / 180), floor_(floorOf(world)) {}

std::optional<ViewPose> ViewPoses::poseAt(std::size_t frame, const WorldObject& object) const {
  const std::optional<Pose>& pose = world_.places.frames[frame].pose;
  if (!pose) return std::nullopt;
  const cv::Point2d from = floor_.position({pose->x, pose->y, pose->z});
  const cv::Point2d ray = floor_.position({object.center.x, object.center.y, object.center.z}) - from;
  const double distance = std::hypot(ray.x, ray.y);
  // Where the robot stood in it nothing can be faced.
  if (!(distance > 0)) return std::nullopt;
  return ViewPose{from.x, from.y, std::atan2(ray.y, ray.x), frame, distance};
}

bool ViewPoses::wallBetween(const cv::Point2d& from, const WorldObject& object) const {
  if (!world_.plan) return false;
  const FloorCells& cells = world_.plan->cells;
  const cv::Point2d to = floor_.position({object.center.x, object.center.y, object.center.z});
  const cv::Point2d ray = to - from;
  const double length = std::hypot(ray.x, ray.y), c = std::cos(object.yaw), s = std::sin(object.yaw);
  // An object on a wall lies in the wall's cells, or beside them. Only there: behind it is the wall's other
  // side.
  const cv::Point2d half(object.size.x / 2 + cells.cell(), object.size.y / 2 + cells.cell());
  for (double at = 0; at < length; at += cells.cell() / 2) {
    const cv::Point2d point = from + ray * (at / length), off = point - to;
    if (std::abs(c * off.x + s * off.y) <= half.x && std::abs(c * off.y - s * off.x) <= half.y) return false;
    const cv::Point cell = cells.at(point.x, point.y);
    if (cells.holds(cell) && world_.plan->walls.at<unsigned char>(cell) != 0) return true;
  }
  return false;
}

std::optional<ViewPose> ViewPoses::find(const WorldObject& object,
                                        const std::function<bool(std::size_t frame)>& mayUse) const {
  const double fits = std::max(reachOf(object), object.size.z / 2) / std::tan(viewAngle_);
  std::optional<ViewPose> whole, middle;
  const auto isNearer = [](const ViewPose& pose, const std::optional<ViewPose>& than) {
    return !than || pose.distance < than->distance;
  };
  for (std::size_t i = 0; i < world_.places.frames.size(); ++i) {
    const std::optional<ViewPose> pose = poseAt(i, object);
    if (!pose || (!isNearer(*pose, whole) && !isNearer(*pose, middle))) continue;
    if (angleTo(object, *world_.places.frames[i].pose) > viewAngle_ || !mayUse(i)) continue;
    if (wallBetween({pose->x, pose->y}, object)) continue;
    if (pose->distance >= fits && isNearer(*pose, whole)) whole = pose;
    if (isNearer(*pose, middle)) middle = pose;
  }
  if (whole) return whole;
  const std::optional<ViewPose> best = poseAt(object.bestFrame, object);
  return best && mayUse(object.bestFrame) ? best : middle;
}

}  // namespace estancia
