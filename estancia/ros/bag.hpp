// Bag: recorded messages of ROS 1 (.bag 2.0) and ROS 2 (rosbag2's .db3, .mcap) as topics, times and payloads.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "estancia/ros/wire.hpp"

namespace estancia::ros {

struct BagTopic {
  /// "/camera/image_raw"
  std::string name;
  /// "sensor_msgs/Image": ROS 2's "sensor_msgs/msg/Image" is written so, too.
  std::string type;
  /// Absent where its messages are neither ROS 1's nor CDR (JSON, Protobuf …): see encodingName.
  std::optional<Encoding> encoding;
  /// Encoding by the name in the file: "ros1", "cdr", "json" …
  std::string encodingName;
  std::size_t messages = 0;
};

struct BagMessage {
  /// Position in Bag::topics().
  std::uint32_t topic = 0;
  /// When it was recorded [ns since 1970].
  std::int64_t time = 0;
};

/// Bytes of a message, kept alive as long as this is.
struct Payload {
  std::shared_ptr<const void> owner;
  std::span<const std::byte> bytes;
};

/// A bag whose messages are all listed when it is opened; payloads are read on request.
class Bag {
 public:
  virtual ~Bag() = default;

  /// In the order of their names, also those without messages; two connections of one topic and type are one.
  const std::vector<BagTopic>& topics() const { return topics_; }
  /// In order of time; those of equal times as they were recorded.
  const std::vector<BagMessage>& messages() const { return messages_; }
  /// Throws Error when this message cannot be read; others may still be. Thread-safe; fastest in order.
  virtual Payload read(std::size_t message) const = 0;
  /// Sentences about the whole bag: it is cut off, a file of it is missing …
  const std::vector<std::string>& warnings() const { return warnings_; }

 protected:
  std::vector<BagTopic> topics_;
  std::vector<BagMessage> messages_;
  std::vector<std::string> warnings_;
};

/// Whether `path` looks like a bag: by its first bytes, or a folder of rosbag2 files.
bool isBag(const std::filesystem::path& path);

/// Opens a file, or a folder of rosbag2: split bags are one. What is whole of a truncated file is used, and a
/// warning reports what is missing. Throws Error: fileNotFound, unsupportedFile, malformedFile, tooLarge.
std::unique_ptr<Bag> openBag(const std::filesystem::path& path);

}  // namespace estancia::ros
