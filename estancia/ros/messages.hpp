// ROS messages: those that a map is made of, read from ROS 1's encoding or CDR.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "estancia/core/pose.hpp"
#include "estancia/ros/wire.hpp"

namespace estancia::ros {

/// A message as it was recorded or received; the bytes must outlive what is read from it.
struct SerializedMessage {
  std::span<const std::byte> bytes;
  Encoding encoding = Encoding::cdr;
};

/// std_msgs/Header
struct Header {
  /// [ns since 1970, or since the robot's or simulation's start]
  std::int64_t stamp = 0;
  /// Without a leading slash.
  std::string frame;
};

/// sensor_msgs/Image. `data` is `height` rows of `step` bytes.
struct ImageMessage {
  Header header;
  std::uint32_t height = 0, width = 0;
  /// "rgb8", "bayer_rggb8", "16UC1" …
  std::string encoding;
  bool bigEndian = false;
  std::uint32_t step = 0;
  std::span<const std::byte> data;
};

/// sensor_msgs/CompressedImage: an image file, or compressedDepth.
struct CompressedImageMessage {
  Header header;
  /// "jpeg", "rgb8; jpeg compressed bgr8", "16UC1; compressedDepth png" …
  std::string format;
  std::span<const std::byte> data;
};

/// sensor_msgs/CameraInfo, without binning and region of interest.
struct CameraInfo {
  Header header;
  std::uint32_t height = 0, width = 0;
  /// "plumb_bob", "rational_polynomial", "equidistant", "fisheye" or ""
  std::string distortionModel;
  std::vector<double> distortion;
  /// Camera matrix of the raw image, and of the rectified one; row-major 3×3 and 3×4 [pixels].
  std::array<double, 9> matrix{};
  std::array<double, 12> projection{};
};

/// sensor_msgs/PointField
struct PointField {
  std::string name;
  std::uint32_t offset = 0;
  /// 1 to 8: int8, uint8, int16, uint16, int32, uint32, float32, float64.
  std::uint8_t type = 0;
  std::uint32_t count = 0;
};

/// sensor_msgs/PointCloud2
struct PointCloudMessage {
  Header header;
  std::uint32_t height = 0, width = 0;
  std::vector<PointField> fields;
  bool bigEndian = false;
  std::uint32_t pointStep = 0, rowStep = 0;
  std::span<const std::byte> data;
};

/// A pose of `child` in the frame of the header: nav_msgs/Odometry, geometry_msgs/PoseStamped and
/// PoseWithCovarianceStamped (whose child is "": whatever it is), TransformStamped. In ROS's axes, and not
/// checked: numbers may be NaN, the quaternion of any length.
struct StampedPose {
  Header header;
  std::string child;
  Pose pose;
};

// Each throws Error: truncatedFile; unsupportedFile for CDR of a kind that ROS 2 does not use.
Header readHeader(const SerializedMessage& message);
ImageMessage readImageMessage(const SerializedMessage& message);
CompressedImageMessage readCompressedImage(const SerializedMessage& message);
CameraInfo readCameraInfo(const SerializedMessage& message);
PointCloudMessage readPointCloud(const SerializedMessage& message);
std::string readString(const SerializedMessage& message);

/// Whether readPoses() reads messages of this type ("nav_msgs/Odometry").
bool isPoseType(const std::string& type);
/// The poses of a message: several of a tf2_msgs/TFMessage, else one. Throws Error, also unknownName.
std::vector<StampedPose> readPoses(const SerializedMessage& message, const std::string& type);

}  // namespace estancia::ros
