// MCAP records: https://mcap.dev/spec
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "estancia/ros/bag_blocks.hpp"
#include "estancia/ros/file_bytes.hpp"

namespace estancia::ros {

constexpr std::string_view mcapMagic{"\x89MCAP0\r\n", 8};
/// Code and length of a record [bytes].
constexpr std::uint64_t mcapRecordHead = 9;
/// Size of the fields before the data in a message: channel, sequence, two times [bytes].
constexpr std::uint64_t mcapMessageHead = 22;

enum class McapOp : std::uint8_t {
  none = 0,
  footer = 2,
  schema = 3,
  channel = 4,
  message = 5,
  chunk = 6,
  messageIndex = 7,
  chunkIndex = 8,
  statistics = 0x0B,
  dataEnd = 0x0F
};

struct McapRecord {
  McapOp op = McapOp::none;
  /// Where its content begins, and where the next record does [bytes].
  std::uint64_t content = 0, end = 0;
  std::uint64_t bytes() const { return end - content; }
};

/// Nothing where not even its head is there; `end` may lie beyond the source.
std::optional<McapRecord> mcapRecordAt(ByteSource& source, std::uint64_t at);

struct McapSchema {
  std::uint16_t id = 0;
  std::string name;
};
struct McapChannel {
  std::uint16_t id = 0, schema = 0;
  std::string topic, encoding;
};
struct McapMessage {
  std::uint16_t channel = 0;
  std::int64_t time = 0;
};
struct McapChunkIndex {
  std::uint64_t chunk = 0, bytes = 0;
  /// Size of the message indexes that follow the chunk [bytes].
  std::uint64_t indexBytes = 0;
};

/// Nothing where the record is damaged.
std::optional<McapSchema> mcapSchema(ByteSource& source, const McapRecord& record);
std::optional<McapChannel> mcapChannel(ByteSource& source, const McapRecord& record);
std::optional<McapMessage> mcapMessage(ByteSource& source, const McapRecord& record);
std::optional<McapChunkIndex> mcapChunkIndex(ByteSource& source, const McapRecord& record);
/// Where its bytes are; those of a record that leaves the source are cut off.
std::optional<BagBlock> mcapChunk(ByteSource& source, const McapRecord& record);

/// Nanoseconds of an MCAP file as ours; the last one that there is for those beyond.
std::int64_t mcapTime(std::uint64_t time);

}  // namespace estancia::ros
