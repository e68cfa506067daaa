// View pose: where on the driven path a robot stands to look at an object. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "estancia/core/pose.hpp"
#include "estancia/world_file/world_map.hpp"
#include "estancia/world_query/route_world.hpp"

namespace estancia {

/// Finds view poses among the poses of the frames.
class ViewPoses {
 public:
  /// `viewAngle` [degrees]: RouteOptions::viewAngle. The world must outlive it.
  ViewPoses(const WorldMap& world, double viewAngle);

  /// The frame nearest to the object, among those that `mayUse`, with all of it in view: its middle within
  /// the view angle, itself far enough away to fit into it, and no wall between. Else the frame that shows it
  /// best; else the nearest that had its middle in view. Nothing where there is none, or without poses.
  std::optional<ViewPose> find(const WorldObject& object,
                               const std::function<bool(std::size_t frame)>& mayUse) const;

 private:
  bool wallBetween(const cv::Point2d& from, const WorldObject& object) const;
  std::optional<ViewPose> poseAt(std::size_t frame, const WorldObject& object) const;

  const WorldMap& world_;
  double viewAngle_;  // [rad]
  Floor floor_;
};

}  // namespace estancia
