// ROS frames: images, depth, camera and poses that come on topics, joined to live frames.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "estancia/readers/undistortion.hpp"
#include "estancia/ros/messages.hpp"
#include "estancia/ros/transform_tree.hpp"
#include "estancia/sources/frame_source.hpp"

namespace estancia {

struct RosFrameOptions {
  /// Whether frames wait for depth, and for a pose: at most `patience`, then they go without.
  bool depth = false, poses = false;
  std::chrono::milliseconds patience{150};
  /// Units per meter of 16-bit depth images; 0: millimeters.
  double depthScale = 0;
  /// Largest time between an image and a pose that is not interpolated [s].
  double maxPoseGap = 0.05;
  /// The topic of images is undistorted already.
  bool isRectified = false;
};

/// Keeps the newest image and what belongs to it; older images are dropped. Thread-safe: messages come in any
/// thread and in CDR. A message that cannot be read is reported by trouble().
class RosFrames {
 public:
  explicit RosFrames(const RosFrameOptions& options);

  /// `type`: "sensor_msgs/Image" or "sensor_msgs/CompressedImage".
  void addImage(std::span<const std::byte> message, const std::string& type);
  void addDepth(std::span<const std::byte> message, const std::string& type);
  /// Sets the camera of the images, and of the depth.
  void addCamera(std::span<const std::byte> message);
  void addDepthCamera(std::span<const std::byte> message);
  /// tf2_msgs/TFMessage of tf or tf_static.
  void addTransforms(std::span<const std::byte> message, bool areStatic);
  /// Any other type of poses, of the robot's body: used where no transforms give the camera's pose.
  void addPose(std::span<const std::byte> message, const std::string& type);

  /// See FrameSource::newest().
  std::optional<LiveFrame> newest(std::chrono::milliseconds patience);
  std::optional<CameraIntrinsics> intrinsics() const;
  std::string trouble() const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Message {
    std::int64_t stamp = 0;
    std::string frame, type;
    std::vector<std::byte> bytes;
    Clock::time_point arrived;
    /// Images are counted from 1.
    std::size_t number = 0;
  };
  void keep(std::deque<Message>& messages, std::span<const std::byte> bytes, const std::string& type);
  const Message* toTake() const;
  const Message* depthOf(std::int64_t stamp) const;
  std::optional<Pose> poseOf(const Message& image) const;
  bool isWhole(const Message& image) const;
  void decode(const Message& image, const std::optional<Message>& depth, LiveFrame& live);
  cv::Mat decodedDepth(const Message& depth, const Message& image);
  void readCamera(std::span<const std::byte> message, bool isRectified, const char* what,
                  std::optional<io::Undistortion>& camera);
  template <class Work>
  void understand(const char* what, const Work& work);

  RosFrameOptions options_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  /// Oldest first. Depth and poses may come later than the images that they belong to.
  std::deque<Message> images_, depths_;
  std::optional<io::Undistortion> camera_, depthCamera_;
  ros::TransformTree transforms_, body_;
  std::string bodyName_;
  std::size_t received_ = 0, taken_ = 0;
  std::string lastName_;
  /// Current problems, by their subjects.
  std::map<std::string, std::string> troubles_;
};

}  // namespace estancia
