// Bag writer: small bags of both ROS for tests, also such as no recorder would write; and what is in a bag.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "estancia/core/error.hpp"
#include "estancia/ros/bag.hpp"

namespace estancia::test {

struct WrittenMessage {
  std::string topic, type;
  std::int64_t time = 0;
  std::string bytes;
};

struct BagWriting {
  /// "none", "lz4", "zstd" (MCAP), "bz2" (ROS 1).
  std::string compression = "none";
  /// A chunk is closed when it has so many bytes; 0: messages lie in no chunk (MCAP).
  std::size_t chunkBytes = 768 * 1024;
  /// Indexes behind chunks.
  bool messageIndex = true;
  /// ROS 1: the index at the end; MCAP: the summary.
  bool index = true;
  /// MCAP: checksums of chunks and of the summary.
  bool checksums = true;
  std::string encoding = "cdr";
};

std::string compressed(const std::string& bytes, const std::string& compression);

std::string ros1Bag(const std::vector<WrittenMessage>& messages, const BagWriting& writing = {});
std::string mcapBag(const std::vector<WrittenMessage>& messages, const BagWriting& writing = {});
void writeSqliteBag(const std::filesystem::path& path, const std::vector<WrittenMessage>& messages);

/// Records and fields, as the writers above put them together.
std::string ros1Field(const std::string& name, const std::string& value);
std::string ros1Record(const std::string& header, const std::string& data);
std::string mcapRecord(unsigned char code, const std::string& content);
/// A little-endian number.
template <class Value>
std::string littleEndian(Value value) {
  return {reinterpret_cast<const char*>(&value), sizeof value};
}

/// Messages by topic.
inline std::map<std::string, std::size_t> countsOf(const ros::Bag& bag) {
  std::map<std::string, std::size_t> counts;
  for (const ros::BagTopic& topic : bag.topics()) counts[topic.name] += topic.messages;
  return counts;
}

inline std::string bytesOf(const ros::Bag& bag, std::size_t message) {
  const ros::Payload payload = bag.read(message);
  return {reinterpret_cast<const char*>(payload.bytes.data()), payload.bytes.size()};
}

/// Topic, type, time and bytes of each message that can be read.
using BagContents = std::multiset<std::tuple<std::string, std::string, std::int64_t, std::string>>;
inline BagContents contentsOf(const ros::Bag& bag, std::size_t* unreadable = nullptr) {
  BagContents contents;
  for (std::size_t i = 0; i < bag.messages().size(); ++i) {
    const ros::BagTopic& topic = bag.topics()[bag.messages()[i].topic];
    try {
      contents.emplace(topic.name, topic.type, bag.messages()[i].time, bytesOf(bag, i));
    } catch (const Error&) {
      if (unreadable == nullptr) throw;
      ++*unreadable;
    }
  }
  return contents;
}

}  // namespace estancia::test
