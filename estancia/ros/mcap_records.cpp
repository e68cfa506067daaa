// SPDX-License-Identifier: Apache-2.0
#include "estancia/ros/mcap_records.hpp"

#include <algorithm>
#include <limits>

#include "estancia/core/bytes.hpp"

namespace estancia::ros {
namespace {

// Names and encodings; a schema's text, which follows, is not needed [bytes].
constexpr std::uint64_t maxNames = 65536;
// Max size of a chunk's index: ten bytes for each of at most 65,536 channels [bytes].
constexpr std::uint64_t maxChunkIndex = std::uint64_t{1} << 20U;

/// Parses at most the first `most` bytes of a record by `parse`; nothing if they are too few.
template <class Parse>
auto parsed(ByteSource& source, const McapRecord& record, std::uint64_t most, Parse parse)
    -> std::optional<decltype(parse(std::declval<ByteReader&>()))> {
  const auto bytes = source.at(record.content, std::min(record.bytes(), most));
  if (!bytes) return std::nullopt;
  try {
    ByteReader reader(*bytes, "record", "copy the file again");
    return parse(reader);
  } catch (const Error&) {
    return std::nullopt;
  }
}

}  // namespace

std::int64_t mcapTime(std::uint64_t time) {
  return static_cast<std::int64_t>(std::min<std::uint64_t>(time, std::numeric_limits<std::int64_t>::max()));
}

std::optional<McapRecord> mcapRecordAt(ByteSource& source, std::uint64_t at) {
  const auto head = source.at(at, mcapRecordHead);
  if (!head) return std::nullopt;
  std::uint64_t length = 0;
  std::memcpy(&length, head->data() + 1, sizeof length);
  const std::uint64_t content = at + mcapRecordHead;
  // Sizes that no file can hold must not wrap around.
  if (length > std::numeric_limits<std::uint64_t>::max() - content) return std::nullopt;
  return McapRecord{static_cast<McapOp>(static_cast<unsigned char>(head->front())), content,
                    content + length};
}

std::optional<McapSchema> mcapSchema(ByteSource& source, const McapRecord& record) {
  return parsed(source, record, maxNames, [](ByteReader& reader) {
    McapSchema schema;
    schema.id = reader.number<std::uint16_t>();
    schema.name = reader.text();
    return schema;
  });
}

std::optional<McapChannel> mcapChannel(ByteSource& source, const McapRecord& record) {
  return parsed(source, record, maxNames, [](ByteReader& reader) {
    McapChannel channel;
    channel.id = reader.number<std::uint16_t>();
    channel.schema = reader.number<std::uint16_t>();
    channel.topic = reader.text();
    channel.encoding = reader.text();
    return channel;
  });
}

std::optional<McapMessage> mcapMessage(ByteSource& source, const McapRecord& record) {
  if (record.bytes() < mcapMessageHead) return std::nullopt;
  const auto bytes = source.at(record.content, mcapMessageHead);
  if (!bytes) return std::nullopt;
  McapMessage message;
  std::uint64_t time = 0;
  std::memcpy(&message.channel, bytes->data(), sizeof message.channel);
  std::memcpy(&time, bytes->data() + 6, sizeof time);
  message.time = mcapTime(time);
  return message;
}

std::optional<McapChunkIndex> mcapChunkIndex(ByteSource& source, const McapRecord& record) {
  return parsed(source, record, maxChunkIndex, [](ByteReader& reader) {
    McapChunkIndex index;
    reader.raw(16);  // its times
    index.chunk = reader.number<std::uint64_t>();
    index.bytes = reader.number<std::uint64_t>();
    reader.raw(reader.number<std::uint32_t>());  // where each channel's message index is
    index.indexBytes = reader.number<std::uint64_t>();
    return index;
  });
}

std::optional<BagBlock> mcapChunk(ByteSource& source, const McapRecord& record) {
  constexpr std::uint64_t maxHead = 256;
  const std::uint64_t rest = source.size() - std::min(record.content, source.size());
  const McapRecord head{record.op, record.content, record.content + std::min(record.bytes(), rest)};
  auto block = parsed(source, head, maxHead, [&](ByteReader& reader) {
    const std::size_t all = reader.remaining();
    BagBlock chunk;
    reader.raw(16);  // its times
    chunk.size = reader.number<std::uint64_t>();
    chunk.crc = reader.number<std::uint32_t>();
    chunk.compression = compressionOf(reader.text());
    chunk.stored = reader.number<std::uint64_t>();
    chunk.at = record.content + (all - reader.remaining());
    return chunk;
  });
  if (!block) return std::nullopt;
  if (block->stored > record.end - block->at) return std::nullopt;
  if (block->compression == Compression::none && block->size != block->stored) return std::nullopt;
  if (block->at + block->stored > source.size()) {
    block->whole = false;
    block->stored = source.size() - block->at;
    if (block->compression == Compression::none) block->size = block->stored;
  }
  return block;
}

}  // namespace estancia::ros
