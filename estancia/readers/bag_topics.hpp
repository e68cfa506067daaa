// Topics of a bag: which hold the images, depth, camera and poses of a drive, and why.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "estancia/readers/message_image.hpp"
#include "estancia/ros/bag.hpp"
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

}  // namespace estancia::io
