// ROS 2 source: live frames of topics, without ROS.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "estancia/ros/dds.hpp"
#include "estancia/sources/ros_frames.hpp"

namespace estancia {

struct RosSourceOptions {
  /// Topics of depth images and of poses, as in SequenceOptions: "" is the only one that fits, "none" none.
  std::string depthTopic, odomTopic;
  /// Units per meter of depth images of 16 bits; 0: millimeters.
  double depthScale = 0;
  /// Largest time between an image and a pose that is not interpolated [s].
  double maxPoseGap = 0.05;
};

/// Whether a source's name is a topic's: "ros2:/camera/image_raw".
bool isRosTopic(const std::string& source);

/// $ROS_DOMAIN_ID, else 0. Throws Error (invalidOption) where it is no number from 0 to 232.
int rosDomain();

/// Live frames of ROS topics. Life cycle: the constructor waits for the topic and subscribes; subscriptions
/// write into `frames_` on threads of their own until the destructor. Invariant: `subscriptions_` end before
/// `frames_` and `node_` do, being declared last.
class RosSource : public FrameSource {
 public:
  /// `node` is ROS 2's graph. Waits some seconds for the topic of images; its publisher may go and come back.
  /// Throws Error: unknownName where there is no such topic of images, with those that there are.
  RosSource(const std::string& source, const RosSourceOptions& options, std::unique_ptr<ros::DdsNode> node);

  std::string name() const override { return source_; }
  std::optional<LiveFrame> newest(std::chrono::milliseconds patience) override {
    return frames_->newest(patience);
  }
  std::string trouble() const override;
  bool hasDepth() const override { return frames_->intrinsics() && !depthTopic_.empty(); }
  bool hasPoses() const override { return hasPoses_; }
  std::optional<CameraIntrinsics> intrinsics() const override { return frames_->intrinsics(); }

 private:
  void subscribe(const RosSourceOptions& options);

  std::string source_, imageTopic_, depthTopic_;
  bool hasPoses_ = false;
  std::unique_ptr<ros::DdsNode> node_;
  std::unique_ptr<RosFrames> frames_;
  std::vector<std::unique_ptr<ros::DdsSubscription>> subscriptions_;  // the first is that of images
};

/// The topics of the graph that are published, as discovered in two seconds, by their names.
std::vector<ros::DdsTopic> discoveredTopics(const ros::DdsNode& node);

/// The topics of the graph as a table for people: name, type, writers.
std::string topicTable(const std::vector<ros::DdsTopic>& topics);

}  // namespace estancia
