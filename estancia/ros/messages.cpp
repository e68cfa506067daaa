// SPDX-License-Identifier: Apache-2.0
#include "estancia/ros/messages.hpp"

#include "estancia/core/fail.hpp"

namespace estancia::ros {
namespace {

WireReader readerOf(const SerializedMessage& message) {
  return {message.bytes, message.encoding};
}

std::string frameOf(WireReader& reader) {
  std::string frame = reader.text();
  if (frame.starts_with('/')) frame.erase(0, 1);  // the form of ROS 1's tf
  return frame;
}

Header headerOf(WireReader& reader) {
  if (reader.encoding() == Encoding::ros1) reader.number<std::uint32_t>();  // the sequence number
  const std::int64_t stamp = reader.time();
  return {stamp, frameOf(reader)};
}

/// geometry_msgs/Pose and Transform: a point or vector, then a quaternion.
Pose poseFrom(WireReader& reader) {
  const auto n = reader.array<double, 7>();
  return {n[0], n[1], n[2], n[3], n[4], n[5], n[6]};
}

StampedPose transformFrom(WireReader& reader) {
  return {headerOf(reader), frameOf(reader), poseFrom(reader)};
}

}  // namespace

// The members of a message are initialized in the order in which they are written.

Header readHeader(const SerializedMessage& message) {
  WireReader reader = readerOf(message);
  return headerOf(reader);
}

ImageMessage readImageMessage(const SerializedMessage& message) {
  WireReader reader = readerOf(message);
  return {headerOf(reader),
          reader.number<std::uint32_t>(),
          reader.number<std::uint32_t>(),
          reader.text(),
          reader.boolean(),
          reader.number<std::uint32_t>(),
          reader.bytes()};
}

CompressedImageMessage readCompressedImage(const SerializedMessage& message) {
  WireReader reader = readerOf(message);
  return {headerOf(reader), reader.text(), reader.bytes()};
}

CameraInfo readCameraInfo(const SerializedMessage& message) {
  WireReader reader = readerOf(message);
  CameraInfo camera;
  camera.header = headerOf(reader);
  camera.height = reader.number<std::uint32_t>();
  camera.width = reader.number<std::uint32_t>();
  camera.distortionModel = reader.text();
  camera.distortion = reader.numbers<double>();
  camera.matrix = reader.array<double, 9>();
  reader.array<double, 9>();  // the rectification, which is the stereo pair's
  camera.projection = reader.array<double, 12>();
  return camera;
}

PointCloudMessage readPointCloud(const SerializedMessage& message) {
  WireReader reader = readerOf(message);
  PointCloudMessage cloud;
  cloud.header = headerOf(reader);
  cloud.height = reader.number<std::uint32_t>();
  cloud.width = reader.number<std::uint32_t>();
  constexpr std::size_t minBytesOfField = 13;
  const std::size_t fields = reader.count(minBytesOfField);
  for (std::size_t i = 0; i < fields; ++i)
    cloud.fields.push_back({reader.text(), reader.number<std::uint32_t>(), reader.number<std::uint8_t>(),
                            reader.number<std::uint32_t>()});
  cloud.bigEndian = reader.boolean();
  cloud.pointStep = reader.number<std::uint32_t>();
  cloud.rowStep = reader.number<std::uint32_t>();
  cloud.data = reader.bytes();
  return cloud;
}

std::string readString(const SerializedMessage& message) {
  return readerOf(message).text();
}

bool isPoseType(const std::string& type) {
  return type == "nav_msgs/Odometry" || type == "geometry_msgs/PoseStamped" ||
         type == "geometry_msgs/PoseWithCovarianceStamped" || type == "geometry_msgs/TransformStamped" ||
         type == "tf2_msgs/TFMessage" || type == "tf/tfMessage";
}

std::vector<StampedPose> readPoses(const SerializedMessage& message, const std::string& type) {
  if (!isPoseType(type)) fail(ErrorCode::unknownName, "{} is no type of poses", type);
  WireReader reader = readerOf(message);
  if (type == "tf2_msgs/TFMessage" || type == "tf/tfMessage") {
    constexpr std::size_t minBytesOfTransform = 72;
    std::vector<StampedPose> transforms(reader.count(minBytesOfTransform));
    for (StampedPose& transform : transforms) transform = transformFrom(reader);
    return transforms;
  }
  if (type == "geometry_msgs/TransformStamped") return {transformFrom(reader)};
  StampedPose pose;
  pose.header = headerOf(reader);
  if (type == "nav_msgs/Odometry") pose.child = frameOf(reader);
  pose.pose = poseFrom(reader);
  return {pose};
}

}  // namespace estancia::ros
