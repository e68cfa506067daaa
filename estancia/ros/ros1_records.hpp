// ROS 1 bag records: header fields and data of bag format 2.0.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>

#include "estancia/ros/file_bytes.hpp"

namespace estancia::ros {

constexpr std::string_view ros1Magic = "#ROSBAG V2.0\n";
/// Headers of messages have some fifty bytes [bytes].
constexpr std::uint64_t maxRos1MessageHeader = 4096;

enum class Ros1Op : std::uint8_t {
  none = 0,
  message = 2,
  bagHeader = 3,
  indexData = 4,
  chunk = 5,
  chunkInfo = 6,
  connection = 7
};

struct Ros1Record {
  Ros1Op op = Ros1Op::none;
  /// Its fields, as they are.
  std::string header;
  /// Where its data are, and where the next record is [bytes].
  std::uint64_t data = 0, end = 0;
  std::uint32_t dataBytes = 0;

  /// The value of a field of the header.
  std::optional<std::string_view> field(std::string_view name) const;
  /// Reads a number; nothing where it has another size.
  template <class Value>
  std::optional<Value> number(std::string_view name) const {
    const auto bytes = field(name);
    if (!bytes || bytes->size() != sizeof(Value)) return std::nullopt;
    Value value{};
    std::memcpy(&value, bytes->data(), sizeof value);
    return value;
  }
};

enum class RecordState {
  whole,
  /// Its header is there, its data leave the source.
  cut,
  /// Not even its header is there.
  none
};

/// Reads the header of the record at `at`.
RecordState readRos1Record(ByteSource& source, std::uint64_t at, Ros1Record& record);

/// The `type` in the data of a connection's record; "" where there is none.
std::string ros1ConnectionType(ByteSource& source, const Ros1Record& connection);

/// Seconds and nanoseconds, as nanoseconds since 1970; nothing unless there are eight bytes.
std::optional<std::int64_t> ros1Time(std::string_view bytes);

}  // namespace estancia::ros
