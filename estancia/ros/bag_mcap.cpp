// MCAP of ROS 2 (and 1): https://mcap.dev/spec
// SPDX-License-Identifier: Apache-2.0
#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <optional>
#include <unordered_map>

#include "estancia/core/bytes.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/ros/bag_files.hpp"
#include "estancia/ros/bag_part.hpp"

namespace estancia::ros {
namespace {

/// Code and length of a record [bytes].
constexpr std::uint64_t mcapRecordHead = 9;
/// Size of the fields before the data in a message: channel, sequence, two times [bytes].
constexpr std::uint64_t mcapMessageHead = 22;
constexpr std::uint64_t mcapFooterBytes = 20;
constexpr std::uint64_t mcapIndexEntry = 16;
// Names and encodings; a schema's text, which follows, is not needed [bytes].
constexpr std::uint64_t maxNames = 65536;
// Max size of a chunk's index: ten bytes for each of at most 65,536 channels [bytes].
constexpr std::uint64_t maxChunkIndex = std::uint64_t{1} << 20U;

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
  bool isDefinition() const { return op == McapOp::schema || op == McapOp::channel; }
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

/// Parses at most the first `most` bytes of a record by `parse`; false if they are too few.
template <class Parse>
bool parsed(ByteSource& source, const McapRecord& record, std::uint64_t most, const Parse& parse) {
  const auto bytes = source.at(record.content, std::min(record.bytes(), most));
  if (!bytes) return false;
  try {
    ByteReader reader(*bytes, "record", "copy the file again");
    parse(reader);
    return true;
  } catch (const Error&) {
    return false;
  }
}

/// Nanoseconds of an MCAP file as ours; the last one that there is for those beyond.
std::int64_t mcapTime(std::uint64_t time) {
  return static_cast<std::int64_t>(std::min<std::uint64_t>(time, std::numeric_limits<std::int64_t>::max()));
}

/// Nothing where not even its head is there; `end` may lie beyond the source.
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

/// Nothing where the record is damaged, as below.
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
  McapChunkIndex index;
  const bool isSound = parsed(source, record, maxChunkIndex, [&](ByteReader& reader) {
    reader.raw(16);  // its times
    index.chunk = reader.number<std::uint64_t>();
    index.bytes = reader.number<std::uint64_t>();
    reader.raw(reader.number<std::uint32_t>());  // where each channel's message index is
    index.indexBytes = reader.number<std::uint64_t>();
  });
  return isSound ? std::optional(index) : std::nullopt;
}

/// Where its bytes are; those of a record that leaves the source are cut off.
std::optional<BagBlock> mcapChunk(ByteSource& source, const McapRecord& record) {
  constexpr std::uint64_t maxHead = 256;
  const std::uint64_t rest = source.size() - std::min(record.content, source.size());
  const McapRecord head{record.op, record.content, record.content + std::min(record.bytes(), rest)};
  BagBlock chunk;
  const bool isSound = parsed(source, head, maxHead, [&](ByteReader& reader) {
    const std::size_t all = reader.remaining();
    reader.raw(16);  // its times
    chunk.size = reader.number<std::uint64_t>();
    chunk.crc = reader.number<std::uint32_t>();
    chunk.compression = compressionOf(reader.text());
    chunk.stored = reader.number<std::uint64_t>();
    chunk.at = record.content + (all - reader.remaining());
  });
  if (!isSound || chunk.stored > record.end - chunk.at) return std::nullopt;
  if (chunk.compression == Compression::none && chunk.size != chunk.stored) return std::nullopt;
  if (chunk.at + chunk.stored > source.size()) {
    chunk.whole = false;
    chunk.stored = source.size() - chunk.at;
    if (chunk.compression == Compression::none) chunk.size = chunk.stored;
  }
  return chunk;
}

/// One MCAP file of a bag. Life cycle: the constructor reads the summary, or scans the whole file where that
/// is missing or damaged; afterwards only read() is called. Invariant: messages refer to blocks that were
/// found in the file, and are checked again when read.
class McapPart final : public ChunkedPart {
 public:
  explicit McapPart(FileBytes file) : ChunkedPart(std::move(file)) {
    FileSource source(blocks_.file());
    try {
      if (readSummary(source)) return;
    } catch (const Error&) {
      // Its chunks are damaged, too: what can be used is found below.
    }
    scan(source);
  }

  Payload read(std::uint32_t block, std::uint64_t offset, std::uint32_t topic) const override {
    const Payload head = blocks_.read(block, offset, mcapRecordHead + mcapMessageHead);
    MemorySource source(head.bytes);
    const auto record = mcapRecordAt(source, 0);
    const auto message = record ? mcapMessage(source, *record) : std::nullopt;
    const auto channel = message ? topicOfChannel_.find(message->channel) : topicOfChannel_.end();
    if (!message || record->op != McapOp::message || channel == topicOfChannel_.end() ||
        channel->second != topic)
      failOfIndex(block);
    const std::uint64_t bytes = record->bytes() - mcapMessageHead;
    if (bytes > maxBlockBytes)
      fail(ErrorCode::tooLarge, "{}: a message of {} bytes; this program takes at most {}", name_, bytes,
           maxBlockBytes);
    return blocks_.readAll(block, offset + mcapRecordHead + mcapMessageHead, bytes);
  }

 private:
  /// A schema or channel. False where it is damaged.
  bool addDefinition(ByteSource& source, const McapRecord& record) {
    return parsed(source, record, maxNames, [&](ByteReader& reader) {
      const auto id = reader.number<std::uint16_t>();
      if (record.op == McapOp::schema) {
        schemas_.emplace(id, reader.text());
        return;
      }
      const auto schema = schemas_.find(reader.number<std::uint16_t>());
      const std::string topic = reader.text(), encoding = reader.text();
      topicOfChannel_.emplace(id,
                              topicNumber(topic, schema == schemas_.end() ? "" : schema->second, encoding));
    });
  }

  // ---- by the summary at the end: each of these is false where it is damaged or incomplete

  bool readSummary(ByteSource& source) {
    const std::uint64_t tail = mcapRecordHead + mcapFooterBytes + mcapMagic.size();
    if (source.size() < mcapMagic.size() + tail) return false;
    const std::uint64_t end = source.size() - tail;
    const auto footer = mcapRecordAt(source, end);
    if (!footer || footer->op != McapOp::footer || footer->bytes() != mcapFooterBytes ||
        source.at(footer->end, mcapMagic.size()) != mcapMagic)
      return false;
    const std::uint64_t begin = source.numberAt<std::uint64_t>(footer->content).value_or(0);
    const std::uint32_t crc = source.numberAt<std::uint32_t>(footer->content + 16).value_or(0);
    if (begin < mcapMagic.size() || begin >= end || !summaryIsSound(begin, footer->content + 16, crc))
      return false;
    std::vector<McapChunkIndex> chunks;
    std::optional<std::uint64_t> messages;
    for (std::uint64_t at = begin; at < end;) {
      const auto record = mcapRecordAt(source, at);
      if (!record || record->end > end) return false;
      if (record->isDefinition()) {
        if (!addDefinition(source, *record)) return false;
      } else if (record->op == McapOp::chunkIndex) {
        const auto index = mcapChunkIndex(source, *record);
        if (!index) return false;
        chunks.push_back(*index);
      } else if (record->op == McapOp::statistics) {
        messages = source.numberAt<std::uint64_t>(record->content);
      }
      at = record->end;
    }
    return messages && readChunks(source, std::move(chunks), begin) && places.size() == *messages;
  }

  bool summaryIsSound(std::uint64_t begin, std::uint64_t end, std::uint32_t crc) const {
    if (crc == 0) return true;
    std::vector<std::byte> bytes(std::min<std::uint64_t>(end - begin, 1U << 20U));
    uLong found = 0;
    for (std::uint64_t at = begin; at < end; at += bytes.size()) {
      bytes.resize(std::min<std::uint64_t>(bytes.size(), end - at));
      blocks_.file().read(at, bytes);
      found = crc32_z(found, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
    }
    return found == crc;
  }

  bool readChunks(ByteSource& source, std::vector<McapChunkIndex> chunks, std::uint64_t dataEnd) {
    // Each byte of the file belongs to one chunk, so that no small file has an index of endless messages.
    std::sort(chunks.begin(), chunks.end(), [](const auto& a, const auto& b) { return a.chunk < b.chunk; });
    std::uint64_t end = mcapMagic.size();
    for (const McapChunkIndex& chunk : chunks) {
      if (chunk.chunk < end || chunk.chunk >= dataEnd) return false;
      const auto record = mcapRecordAt(source, chunk.chunk);
      if (!record || record->op != McapOp::chunk || record->end > dataEnd ||
          record->end - chunk.chunk != chunk.bytes || chunk.indexBytes > dataEnd - record->end)
        return false;
      const auto block = mcapChunk(source, *record);
      if (!block) return false;
      const std::uint32_t number = blocks_.add(*block);
      end = record->end + chunk.indexBytes;
      const std::size_t before = places.size();
      for (std::uint64_t at = record->end; at < end;) {
        const auto index = mcapRecordAt(source, at);
        if (!index || index->op != McapOp::messageIndex || index->end > end ||
            !readMessageIndex(source, *index, number))
          return false;
        at = index->end;
      }
      // Without an index, as a writer may choose.
      if (places.size() == before && !scanBlock(number)) return false;
    }
    return true;
  }

  bool readMessageIndex(ByteSource& source, const McapRecord& record, std::uint32_t block) {
    const auto channel = source.numberAt<std::uint16_t>(record.content);
    const auto bytes = source.numberAt<std::uint32_t>(record.content + 2);
    if (!channel || !bytes || record.bytes() != *bytes + 6ULL || *bytes % mcapIndexEntry != 0) return false;
    const auto topic = topicOfChannel_.find(*channel);
    if (topic == topicOfChannel_.end()) return false;
    for (std::uint64_t at = record.content + 6; at < record.end; at += mcapIndexEntry) {
      const auto entry = source.at(at, mcapIndexEntry);
      std::uint64_t time = 0, offset = 0;
      std::memcpy(&time, entry->data(), sizeof time);
      std::memcpy(&offset, entry->data() + 8, sizeof offset);
      if (offset >= blocks_[block].size) return false;
      addPlace({mcapTime(time), offset, block, topic->second});
    }
    return true;
  }

  // ---- without

  void scan(ByteSource& source) {
    topicOfChannel_.clear();
    const std::uint32_t wholeFile = restart();
    bool whole = true, ended = false;
    std::uint64_t at = mcapMagic.size();
    while (at < source.size() && whole && !ended) {
      const auto record = mcapRecordAt(source, at);
      whole = record && (record->end <= source.size() || record->op == McapOp::chunk);
      if (!whole) break;
      ended = record->op == McapOp::dataEnd || record->op == McapOp::footer;
      if (record->op == McapOp::chunk) {
        const auto chunk = mcapChunk(source, *record);
        if (chunk) scanChunk(*chunk);
        whole = chunk && chunk->whole && record->end <= source.size();
      } else if (record->isDefinition()) {
        whole = addDefinition(source, *record);
      } else if (record->op == McapOp::message) {
        const auto message = mcapMessage(source, *record);
        whole = message.has_value();
        if (message) addMessage(*message, wholeFile, at);
      } else {
        whole = record->op != McapOp::none;
      }
      if (whole) at = record->end;
    }
    warnOfScan(whole && ended, at);
  }

  bool scanRecords(ByteSource& source, std::uint32_t block) override {
    for (std::uint64_t at = 0; at < source.size();) {
      const auto record = mcapRecordAt(source, at);
      if (!record || record->end > source.size()) return false;
      if (record->op == McapOp::message) {
        const auto message = mcapMessage(source, *record);
        if (!message) return false;
        addMessage(*message, block, at);
      } else if (record->isDefinition()) {
        if (!addDefinition(source, *record)) return false;
      }
      at = record->end;
    }
    return true;
  }

  void addMessage(const McapMessage& message, std::uint32_t block, std::uint64_t offset) {
    const auto topic = topicOfChannel_.find(message.channel);
    if (topic == topicOfChannel_.end())
      ++unknown_;
    else
      addPlace({message.time, offset, block, topic->second});
  }

  std::unordered_map<std::uint16_t, std::string> schemas_;
  std::unordered_map<std::uint16_t, std::uint32_t> topicOfChannel_;
};

}  // namespace

std::unique_ptr<BagPart> openMcapPart(FileBytes file) {
  return std::make_unique<McapPart>(std::move(file));
}

}  // namespace estancia::ros
