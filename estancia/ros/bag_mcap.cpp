// MCAP of ROS 2 (and 1): https://mcap.dev/spec
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <optional>
#include <unordered_map>

#include "estancia/core/fail.hpp"
#include "estancia/ros/bag_part.hpp"
#include "estancia/ros/mcap_records.hpp"

namespace estancia::ros {
namespace {

constexpr std::uint64_t mcapFooterBytes = 20;
constexpr std::uint64_t mcapIndexEntry = 16;

class McapPart : public BagPart {
 public:
  explicit McapPart(FileBytes file) : BagPart(file.name()), blocks_(std::move(file)) {
    FileSource source(blocks_.file());
    try {
      if (readSummary(source)) return;
    } catch (const Error&) {
      // Its chunks are damaged, too: what can be used is found below.
    }
    scan(source);
  }

  std::uint32_t blocks() const override { return blocks_.count(); }

  Payload read(std::uint32_t block, std::uint64_t offset, std::uint32_t topic) const override {
    const Payload head = blocks_.read(block, offset, mcapRecordHead + mcapMessageHead);
    MemorySource source(head.bytes);
    const auto record = mcapRecordAt(source, 0);
    const auto message = record ? mcapMessage(source, *record) : std::nullopt;
    const auto channel = message ? topicOfChannel_.find(message->channel) : topicOfChannel_.end();
    if (!message || record->op != McapOp::message || channel == topicOfChannel_.end() ||
        channel->second != topic)
      fail(ErrorCode::corruptFile,
           "{}: the chunk at byte {} does not have the message that the index tells; copy the file again",
           name_, blocks_[block].at);
    const std::uint64_t bytes = record->bytes() - mcapMessageHead;
    if (bytes > maxBlockBytes)
      fail(ErrorCode::tooLarge, "{}: a message of {} bytes; this program takes at most {}", name_, bytes,
           maxBlockBytes);
    return blocks_.readAll(block, offset + mcapRecordHead + mcapMessageHead, bytes);
  }

 private:
  bool addDefinition(ByteSource& source, const McapRecord& record);
  void restart();
  bool readSummary(ByteSource& source);
  bool summaryIsSound(std::uint64_t begin, std::uint64_t end, std::uint32_t crc) const;
  bool readChunks(ByteSource& source, std::vector<McapChunkIndex> chunks, std::uint64_t dataEnd);
  bool readMessageIndex(ByteSource& source, const McapRecord& record, std::uint32_t block);
  void scan(ByteSource& source);
  bool scanChunk(ByteSource& source, const McapRecord& record);
  bool scanBlock(std::uint32_t block);
  bool scanRecords(ByteSource& source, std::uint32_t block);
  void addMessage(const McapMessage& message, std::uint32_t block, std::uint64_t offset);

  BagBlocks blocks_;
  std::unordered_map<std::uint16_t, std::string> schemas_;
  std::unordered_map<std::uint16_t, std::uint32_t> topicOfChannel_;
  /// Counters of the scan.
  std::uint64_t unknown_ = 0, damagedChunks_ = 0;
  std::string firstDamage_;
};

void McapPart::restart() {
  places.clear();
  blocks_.clear();
  topicOfChannel_.clear();
}

/// A schema or channel. False where it is damaged.
bool McapPart::addDefinition(ByteSource& source, const McapRecord& record) {
  if (record.op == McapOp::schema) {
    const auto schema = mcapSchema(source, record);
    if (schema) schemas_.emplace(schema->id, schema->name);
    return schema.has_value();
  }
  const auto channel = mcapChannel(source, record);
  if (!channel) return false;
  const auto schema = schemas_.find(channel->schema);
  topicOfChannel_.emplace(
      channel->id,
      topicNumber(channel->topic, schema == schemas_.end() ? "" : schema->second, channel->encoding));
  return true;
}

// ---- by the summary at the end: each of these is false where it is damaged or incomplete

bool McapPart::readSummary(ByteSource& source) {
  restart();
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
    if (record->op == McapOp::schema || record->op == McapOp::channel) {
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

bool McapPart::summaryIsSound(std::uint64_t begin, std::uint64_t end, std::uint32_t crc) const {
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

bool McapPart::readChunks(ByteSource& source, std::vector<McapChunkIndex> chunks, std::uint64_t dataEnd) {
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

bool McapPart::readMessageIndex(ByteSource& source, const McapRecord& record, std::uint32_t block) {
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

void McapPart::scan(ByteSource& source) {
  restart();
  const std::uint32_t wholeFile = blocks_.add({0, source.size(), source.size(), Compression::none, 0, true});
  bool whole = true, ended = false;
  std::uint64_t at = mcapMagic.size();
  while (at < source.size() && whole && !ended) {
    const auto record = mcapRecordAt(source, at);
    whole = record && (record->end <= source.size() || record->op == McapOp::chunk);
    if (!whole) break;
    ended = record->op == McapOp::dataEnd || record->op == McapOp::footer;
    if (record->op == McapOp::chunk) {
      whole = scanChunk(source, *record);
    } else if (record->op == McapOp::schema || record->op == McapOp::channel) {
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
  if (!whole || !ended)
    warnings.push_back(
        fmt::format("{}: it is cut off or damaged at byte {}; what was whole of the {} bytes from "
                    "there is used, the rest is missing",
                    name_, at, source.size() - at));
  if (damagedChunks_ > 0)
    warnings.push_back(
        fmt::format("{}: {} of its chunks are damaged; first: {}", name_, damagedChunks_, firstDamage_));
  if (unknown_ > 0)
    warnings.push_back(fmt::format("{}: {} messages of unknown topics are left out", name_, unknown_));
}

/// False where nothing can follow.
bool McapPart::scanChunk(ByteSource& source, const McapRecord& record) {
  const auto block = mcapChunk(source, record);
  if (!block) return false;
  try {
    if (!scanBlock(blocks_.add(*block)) && block->whole)
      fail(ErrorCode::corruptFile, "the chunk at byte {} holds other things than messages", block->at);
  } catch (const Error& error) {
    if (damagedChunks_++ == 0) firstDamage_ = error.what();
  }
  return block->whole && record.end <= source.size();
}

bool McapPart::scanBlock(std::uint32_t number) {
  const BagBlock& block = blocks_[number];
  if (block.compression == Compression::none) {
    FileSource source(blocks_.file(), block.at, block.stored);
    return scanRecords(source, number);
  }
  const Payload bytes = blocks_.load(number);
  MemorySource source(bytes.bytes);
  return scanRecords(source, number);
}

bool McapPart::scanRecords(ByteSource& source, std::uint32_t block) {
  for (std::uint64_t at = 0; at < source.size();) {
    const auto record = mcapRecordAt(source, at);
    if (!record || record->end > source.size()) return false;
    if (record->op == McapOp::message) {
      const auto message = mcapMessage(source, *record);
      if (!message) return false;
      addMessage(*message, block, at);
    } else if (record->op == McapOp::schema || record->op == McapOp::channel) {
      if (!addDefinition(source, *record)) return false;
    }
    at = record->end;
  }
  return true;
}

void McapPart::addMessage(const McapMessage& message, std::uint32_t block, std::uint64_t offset) {
  const auto topic = topicOfChannel_.find(message.channel);
  if (topic == topicOfChannel_.end())
    ++unknown_;
  else
    addPlace({message.time, offset, block, topic->second});
}

}  // namespace

std::unique_ptr<BagPart> openMcapPart(FileBytes file) {
  return std::make_unique<McapPart>(std::move(file));
}

}  // namespace estancia::ros
