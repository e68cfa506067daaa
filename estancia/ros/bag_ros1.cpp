// ROS 1's bag format 2.0: http://wiki.ros.org/Bags/Format/2.0
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <unordered_map>

#include "estancia/core/fail.hpp"
#include "estancia/ros/bag_part.hpp"
#include "estancia/ros/ros1_records.hpp"

namespace estancia::ros {
namespace {

constexpr std::uint64_t ros1IndexEntry = 12, ros1ChunkInfoEntry = 8;

/// Index entry of a chunk.
struct Ros1ChunkInfo {
  std::uint64_t at = 0;
  std::uint32_t connections = 0;
  std::uint64_t messages = 0;
};

class Ros1Part : public BagPart {
 public:
  explicit Ros1Part(FileBytes file) : BagPart(file.name()), blocks_(std::move(file)) {
    FileSource source(blocks_.file());
    Ros1Record header;
    if (readRos1Record(source, ros1Magic.size(), header) != RecordState::whole ||
        header.op != Ros1Op::bagHeader)
      fail(ErrorCode::malformedFile, "{}: the header of the bag is damaged; copy the file again", name_);
    if (!header.field("encryptor").value_or("").empty())
      fail(ErrorCode::unsupportedFile, "{}: the bag is encrypted; decrypt it with `rosbag decrypt`", name_);
    const auto index = header.number<std::uint64_t>("index_pos").value_or(0);
    if (index != 0 && readIndex(source, index, header)) return;
    scan(source, header.end);
    warnings.insert(warnings.begin(),
                    fmt::format("{}: {}, so it was read through to find its messages", name_,
                                index == 0 ? "it was not closed" : "its index is cut off or damaged"));
  }

  std::uint32_t blocks() const override { return blocks_.count(); }

  Payload read(std::uint32_t block, std::uint64_t offset, std::uint32_t topic) const override {
    const Payload head = blocks_.read(block, offset, maxRos1MessageHeader);
    MemorySource source(head.bytes);
    Ros1Record record;
    if (readRos1Record(source, 0, record) == RecordState::none || topicOf(record) != topic)
      fail(ErrorCode::corruptFile,
           "{}: the chunk at byte {} does not have the message that the index tells; copy the file again",
           name_, blocks_[block].at);
    return blocks_.readAll(block, offset + record.data, record.dataBytes);
  }

 private:
  /// Nothing where it is no message, or one of an unknown connection.
  std::optional<std::uint32_t> topicOf(const Ros1Record& record) const {
    const auto connection = record.number<std::uint32_t>("conn");
    if (record.op != Ros1Op::message || !connection) return std::nullopt;
    const auto found = topicOfConnection_.find(*connection);
    return found == topicOfConnection_.end() ? std::nullopt : std::optional(found->second);
  }

  bool addConnection(ByteSource& source, const Ros1Record& record) {
    const auto number = record.number<std::uint32_t>("conn");
    const auto topic = record.field("topic");
    if (!number || !topic) return false;
    topicOfConnection_.emplace(*number, topicNumber(*topic, ros1ConnectionType(source, record), "ros1"));
    return true;
  }

  /// Nothing where its header is damaged.
  static std::optional<BagBlock> chunkOf(const Ros1Record& record) {
    const auto size = record.number<std::uint32_t>("size");
    const auto compression = record.field("compression");
    if (!size || !compression) return std::nullopt;
    const BagBlock block{record.data, record.dataBytes, *size, compressionOf(*compression), 0, true};
    if (block.compression == Compression::none && block.size != block.stored) return std::nullopt;
    return block;
  }

  bool readIndex(ByteSource& source, std::uint64_t at, const Ros1Record& header);
  bool readChunkInfo(ByteSource& source, const Ros1Record& record, std::vector<Ros1ChunkInfo>& chunks) const;
  bool readChunkIndex(ByteSource& source, const Ros1ChunkInfo& chunk, std::uint64_t& end);
  bool readIndexData(ByteSource& source, const Ros1Record& record, std::uint32_t block);
  void scan(ByteSource& source, std::uint64_t at);
  bool scanChunk(const Ros1Record& record, bool whole);
  bool scanRecords(ByteSource& source, std::uint32_t block);
  void addMessage(const Ros1Record& record, std::uint32_t block, std::uint64_t offset);

  BagBlocks blocks_;
  std::unordered_map<std::uint32_t, std::uint32_t> topicOfConnection_;
  /// Counters of the scan.
  std::uint64_t unknown_ = 0, damagedChunks_ = 0;
  std::string firstDamage_;
};

// ---- with an index: each of these is false where it is damaged

bool Ros1Part::readIndex(ByteSource& source, std::uint64_t begin, const Ros1Record& header) {
  std::vector<Ros1ChunkInfo> chunks;
  std::uint64_t connections = 0;
  Ros1Record record;
  if (begin < header.end) return false;
  for (std::uint64_t at = begin; at < source.size(); at = record.end) {
    if (readRos1Record(source, at, record) != RecordState::whole) return false;
    if (record.op == Ros1Op::connection) {
      if (!addConnection(source, record)) return false;
      ++connections;
    } else if (record.op != Ros1Op::chunkInfo || !readChunkInfo(source, record, chunks)) {
      return false;
    }
  }
  if (header.number<std::uint32_t>("conn_count") != connections ||
      header.number<std::uint32_t>("chunk_count") != chunks.size())
    return false;
  // Each byte of the file belongs to one chunk, so that no small file has an index of endless messages.
  std::sort(chunks.begin(), chunks.end(), [](const auto& a, const auto& b) { return a.at < b.at; });
  std::uint64_t end = header.end;
  for (const Ros1ChunkInfo& chunk : chunks)
    if (chunk.at < end || !readChunkIndex(source, chunk, end) || end > begin) return false;
  return true;
}

bool Ros1Part::readChunkInfo(ByteSource& source, const Ros1Record& record,
                             std::vector<Ros1ChunkInfo>& chunks) const {
  const auto position = record.number<std::uint64_t>("chunk_pos");
  const auto count = record.number<std::uint32_t>("count");
  if (!position || !count || record.dataBytes != *count * ros1ChunkInfoEntry) return false;
  Ros1ChunkInfo chunk{*position, *count, 0};
  for (std::uint64_t at = record.data; at < record.end; at += ros1ChunkInfoEntry)
    chunk.messages += source.numberAt<std::uint32_t>(at + 4).value_or(0);
  chunks.push_back(chunk);
  return true;
}

bool Ros1Part::readChunkIndex(ByteSource& source, const Ros1ChunkInfo& chunk, std::uint64_t& end) {
  Ros1Record record;
  if (readRos1Record(source, chunk.at, record) != RecordState::whole || record.op != Ros1Op::chunk)
    return false;
  const auto block = chunkOf(record);
  if (!block) return false;
  const std::uint32_t number = blocks_.add(*block);
  const std::size_t before = places.size();
  end = record.end;
  for (std::uint32_t i = 0; i < chunk.connections; ++i, end = record.end)
    if (readRos1Record(source, end, record) != RecordState::whole || record.op != Ros1Op::indexData ||
        !readIndexData(source, record, number))
      return false;
  return places.size() - before == chunk.messages;
}

bool Ros1Part::readIndexData(ByteSource& source, const Ros1Record& record, std::uint32_t block) {
  const auto connection = record.number<std::uint32_t>("conn");
  const auto count = record.number<std::uint32_t>("count");
  if (!connection || !count || record.number<std::uint32_t>("ver") != 1U) return false;
  const auto topic = topicOfConnection_.find(*connection);
  if (topic == topicOfConnection_.end() || record.dataBytes != *count * ros1IndexEntry) return false;
  for (std::uint64_t at = record.data; at < record.end; at += ros1IndexEntry) {
    const auto entry = source.at(at, ros1IndexEntry);
    std::uint32_t offset = 0;
    std::memcpy(&offset, entry->data() + 8, sizeof offset);
    if (offset >= blocks_[block].size) return false;
    addPlace({*ros1Time(entry->substr(0, 8)), offset, block, topic->second});
  }
  return true;
}

// ---- without

void Ros1Part::scan(ByteSource& source, std::uint64_t at) {
  places.clear();
  blocks_.clear();
  topicOfConnection_.clear();
  // Messages of a recorder that died lie in no chunk.
  const std::uint32_t wholeFile = blocks_.add({0, source.size(), source.size(), Compression::none, 0, true});
  bool whole = true;
  for (Ros1Record record; at < source.size() && whole; at = whole ? record.end : at) {
    const RecordState state = readRos1Record(source, at, record);
    whole = state == RecordState::whole;
    if (record.op == Ros1Op::chunk)
      whole = scanChunk(record, whole);
    else if (whole && record.op == Ros1Op::connection)
      whole = addConnection(source, record);
    else if (whole && record.op == Ros1Op::message)
      addMessage(record, wholeFile, at);
    else
      whole = whole && record.op >= Ros1Op::bagHeader && record.op <= Ros1Op::chunkInfo;
  }
  if (!whole) {
    const std::uint64_t lost = source.size() - at;
    warnings.push_back(
        fmt::format("{}: it is cut off or damaged at byte {}; what was whole of the {} bytes from "
                    "there is used, the rest is missing",
                    name_, at, lost));
  }
  if (damagedChunks_ > 0)
    warnings.push_back(
        fmt::format("{}: {} of its chunks are damaged; first: {}", name_, damagedChunks_, firstDamage_));
  if (unknown_ > 0)
    warnings.push_back(fmt::format("{}: {} messages of unknown topics are left out", name_, unknown_));
}

/// False where nothing can follow.
bool Ros1Part::scanChunk(const Ros1Record& record, bool whole) {
  const std::uint64_t rest = blocks_.file().size() - record.data;
  auto block = chunkOf(record);
  if (!block) return false;
  // A recorder that died has not written the size yet. Its messages follow, or its compressed bytes do.
  if (block->stored == 0 && block->compression == Compression::none) return true;
  const bool cut = !whole || block->stored == 0;
  if (cut) {
    block->stored = rest;
    block->whole = false;
    if (block->compression == Compression::none) block->size = rest;
  }
  const std::uint32_t number = blocks_.add(*block);
  try {
    bool complete = true;
    if (block->compression == Compression::none) {
      FileSource source(blocks_.file(), block->at, block->stored);
      complete = scanRecords(source, number);
    } else {
      const Payload bytes = blocks_.load(number);
      MemorySource source(bytes.bytes);
      complete = scanRecords(source, number);
    }
    if (!complete && !cut)
      fail(ErrorCode::corruptFile, "the chunk at byte {} holds other things than messages", block->at);
  } catch (const Error& error) {
    if (damagedChunks_++ == 0) firstDamage_ = error.what();
  }
  return !cut;
}

bool Ros1Part::scanRecords(ByteSource& source, std::uint32_t block) {
  Ros1Record record;
  for (std::uint64_t at = 0; at < source.size(); at = record.end) {
    if (readRos1Record(source, at, record) != RecordState::whole) return false;
    if (record.op == Ros1Op::message)
      addMessage(record, block, at);
    else if (record.op != Ros1Op::connection || !addConnection(source, record))
      return false;
  }
  return true;
}

void Ros1Part::addMessage(const Ros1Record& record, std::uint32_t block, std::uint64_t offset) {
  const auto topic = topicOf(record);
  const auto time = ros1Time(record.field("time").value_or(""));
  if (topic && time)
    addPlace({*time, offset, block, *topic});
  else
    ++unknown_;
}

}  // namespace

std::unique_ptr<BagPart> openRos1Part(FileBytes file) {
  return std::make_unique<Ros1Part>(std::move(file));
}

}  // namespace estancia::ros
