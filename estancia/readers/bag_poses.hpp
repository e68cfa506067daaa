// Poses of a bag: where the camera was, by transforms or odometry, interpolated in time.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "estancia/core/pose.hpp"
#include "estancia/readers/bag_topics.hpp"
#include "estancia/ros/bag.hpp"
#include "estancia/ros/transform_tree.hpp"

namespace estancia::io {

/// The frames camera ← … ← base ← odom ← map, as far as the bag contains them. All poses are in the frame
/// above all others: "map" where something localizes the robot, else "odom".
class BagPoses {
 public:
  /// `camera`: the frame of the images. Reads all transforms, and the topics of poses until one gives the
  /// camera's pose. `maxGap`: largest time between an image and a pose that is not interpolated [s].
  BagPoses(const ros::Bag& bag, const std::vector<ChosenTopic>& topics, const std::string& camera,
           double maxGap);

  /// T_map_camera at a time [ns]; nothing where it is not known.
  std::optional<Pose> find(std::int64_t time) const;
  /// T_camera_other at a time [ns]: of two cameras of the robot.
  std::optional<cv::Affine3d> findBetween(const std::string& camera, const std::string& other,
                                          std::int64_t time) const {
    return transforms_.find(camera, other, time);
  }
  /// The topic that they are of; nothing where the bag has no poses of the camera.
  const std::optional<ChosenTopic>& topic() const { return topic_; }
  /// Sentences about what is missing, or taken for granted.
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  void readTransforms(const ros::Bag& bag);
  bool useTransforms();
  bool usePoses(const ros::Bag& bag, const ChosenTopic& topic);

  std::string camera_, root_;
  ros::TransformTree transforms_, poses_;
  /// T_body_camera if no transform gives it.
  std::optional<cv::Affine3d> mount_;
  std::string body_;
  std::optional<ChosenTopic> topic_;
  std::vector<std::string> warnings_;
};

}  // namespace estancia::io
