// Topics of a bag: which hold images, depth, camera and poses of a drive and why; where the camera was.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "estancia/core/pose.hpp"
#include "estancia/readers/message_image.hpp"
#include "estancia/ros/bag.hpp"
#include "estancia/ros/transform_tree.hpp"
#include "estancia/sequences/sequence.hpp"

namespace estancia::io {

/// The topic of a bag whose images, depth … are used, by its position in Bag::topics(), and why that one.
struct ChosenTopic {
  std::size_t topic = 0;
  std::string why;
};

struct BagTopics {
  std::optional<ChosenTopic> images, depth;
  /// sensor_msgs/CameraInfo of the images, and of the depth.
  std::optional<ChosenTopic> imageCamera, depthCamera;
  /// Topics that may hold poses, best first: the one that is named, else tf, else the only topic of poses. tf
  /// and tf_static are one, and `topic` is the first of them that moves.
  std::vector<ChosenTopic> poses;
  /// Why there are no images: a sentence with the topics that could be meant; "" where there are.
  std::string whyNoImages;
  /// Why there is no depth, or there are no poses, although the bag holds some.
  std::vector<std::string> warnings;
};

/// The topics that the options name, else those that alone fit. Reads the first message of each topic of
/// images. Throws Error (unknownName) where the bag has no such topic, or it is of another type.
BagTopics chooseTopics(const ros::Bag& bag, const SequenceOptions& options);

/// "/camera/color" of "/camera/color/image_raw/compressed".
std::string cameraNamespace(const std::string& topic);

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

namespace estancia {

struct TopicSummary {
  std::string name, type;
  std::size_t messages = 0;
  /// Messages a second, and the longest time without one [s], by when they were recorded; 0 for one.
  double rate = 0, longestGap = 0;
  /// Use of the topic: "images", "depth", "camera", "camera of depth", "poses"; "" for nothing.
  std::string use;
  /// Why it is used.
  std::string why;
};

/// The topics of a bag, and which a map would be made of.
struct BagSummary {
  std::vector<TopicSummary> topics;
  /// From the first message to the last [s].
  double duration = 0;
  /// Why it has no images to use, as a sentence; "" where it has.
  std::string whyNoImages;
  /// Faults of the file: it is cut off, a part is missing …
  std::vector<std::string> warnings;
};

/// Throws Error as openSequence() does for bags, but not for want of images.
BagSummary summarizeBag(const std::filesystem::path& bag, const SequenceOptions& options = {});

}  // namespace estancia
