// ROS 2 publisher: where the robot is, and the map as markers, for nodes, RViz, Foxglove and Lichtblick.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <thread>

#include "estancia/ros/dds.hpp"
#include "estancia/ros/published_messages.hpp"
#include "estancia/site/queries.hpp"

namespace estancia {

/// Publishes until it is destroyed: on /estancia/where (std_msgs/String) the JSON of LiveQueries::where()
/// with each change, ten a second at most; on /estancia/map (visualization_msgs/MarkerArray of Humble and
/// later, kept for who comes later) the map when it has changed, in the frame "map".
class RosPublisher {
 public:
  /// The view must outlive it.
  RosPublisher(const LiveView& view, std::unique_ptr<ros::DdsNode> node);
  ~RosPublisher();
  RosPublisher(const RosPublisher&) = delete;
  RosPublisher& operator=(const RosPublisher&) = delete;

 private:
  void run();

  const LiveView& view_;
  LiveQueries queries_;
  std::unique_ptr<ros::DdsNode> node_;
  std::unique_ptr<ros::DdsPublication> where_, map_;
  std::atomic<bool> over_ = false;
  std::thread thread_;  // last: it uses all others
};

/// A map with poses as markers: places (spheres), transitions (lines), areas (names where the robot drove),
/// objects (boxes and names). The first one removes what was drawn before; without poses it is the only one.
std::vector<ros::Marker> markersOf(const WorldMap& world);

}  // namespace estancia
