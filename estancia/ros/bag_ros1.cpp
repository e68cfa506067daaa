// ROS 1's bag format 2.0: http://wiki.ros.org/Bags/Format/2.0
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <optional>
#include <unordered_map>

#include "estancia/core/fail.hpp"
#include "estancia/ros/bag_files.hpp"
#include "estancia/ros/bag_part.hpp"

namespace estancia::ros {
namespace {

constexpr std::uint64_t ros1IndexEntry = 12, ros1ChunkInfoEntry = 8;
/// Headers of messages have some fifty bytes [bytes].
constexpr std::uint64_t maxRos1MessageHeader = 4096;
// Connections have their topic and little more in it [bytes].
constexpr std::uint32_t maxHeader = 65536;
// The type in the data of a connection; its message's definition may be longer [bytes].
constexpr std::uint32_t maxTypeField = 4096;

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
  std::optional<std::string_view> field(std::string_view name) const {
    for (std::string_view rest = header; rest.size() >= 4;) {
      std::uint32_t length = 0;
      std::memcpy(&length, rest.data(), sizeof length);
      rest.remove_prefix(4);
      if (length > rest.size()) return std::nullopt;
      const std::string_view entry = rest.substr(0, length);
      rest.remove_prefix(length);
      if (entry.size() > name.size() && entry.starts_with(name) && entry[name.size()] == '=')
        return entry.substr(name.size() + 1);
    }
    return std::nullopt;
  }
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
RecordState readRos1Record(ByteSource& source, std::uint64_t at, Ros1Record& record) {
  record = {};
  const auto length = source.numberAt<std::uint32_t>(at);
  if (!length || *length > maxHeader) return RecordState::none;
  // With the length of the data behind it.
  const auto header = source.at(at + 4, std::uint64_t{*length} + 4);
  if (!header) return RecordState::none;
  record.header = header->substr(0, *length);
  std::memcpy(&record.dataBytes, header->data() + *length, sizeof record.dataBytes);
  record.data = at + 4 + *length + 4;
  record.end = record.data + record.dataBytes;
  const auto op = record.number<std::uint8_t>("op");
  if (!op) return RecordState::none;
  record.op = static_cast<Ros1Op>(*op);
  return record.end <= source.size() ? RecordState::whole : RecordState::cut;
}

/// The `type` in the data of a connection's record; "" where there is none.
std::string ros1ConnectionType(ByteSource& source, const Ros1Record& connection) {
  constexpr std::string_view type = "type=";
  for (std::uint64_t at = connection.data; at + 4 <= connection.end;) {
    const auto length = source.numberAt<std::uint32_t>(at);
    at += 4;
    if (!length || *length > connection.end - at) break;
    const auto entry = source.at(at, std::min(*length, maxTypeField));
    if (entry && entry->starts_with(type)) return std::string(entry->substr(type.size()));
    at += *length;
  }
  return "";
}

/// Seconds and nanoseconds, as nanoseconds since 1970; nothing unless there are eight bytes.
std::optional<std::int64_t> ros1Time(std::string_view bytes) {
  if (bytes.size() != 8) return std::nullopt;
  std::uint32_t seconds = 0, nanoseconds = 0;
  std::memcpy(&seconds, bytes.data(), sizeof seconds);
  std::memcpy(&nanoseconds, bytes.data() + 4, sizeof nanoseconds);
  return std::int64_t{seconds} * 1'000'000'000 + nanoseconds;
}

/// Index entry of a chunk.
struct Ros1ChunkInfo {
  std::uint64_t at = 0;
  std::uint32_t connections = 0;
  std::uint64_t messages = 0;
};

class Ros1Part final : public ChunkedPart {
 public:
  explicit Ros1Part(FileBytes file) : ChunkedPart(std::move(file)) {
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

  Payload read(std::uint32_t block, std::uint64_t offset, std::uint32_t topic) const override {
    const Payload head = blocks_.read(block, offset, maxRos1MessageHeader);
    MemorySource source(head.bytes);
    Ros1Record record;
    if (readRos1Record(source, 0, record) == RecordState::none || topicOf(record) != topic)
      failOfIndex(block);
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

  // ---- with an index: each of these is false where it is damaged

  bool readIndex(ByteSource& source, std::uint64_t begin, const Ros1Record& header) {
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

  bool readChunkInfo(ByteSource& source, const Ros1Record& record, std::vector<Ros1ChunkInfo>& chunks) const {
    const auto position = record.number<std::uint64_t>("chunk_pos");
    const auto count = record.number<std::uint32_t>("count");
    if (!position || !count || record.dataBytes != *count * ros1ChunkInfoEntry) return false;
    Ros1ChunkInfo chunk{*position, *count, 0};
    for (std::uint64_t at = record.data; at < record.end; at += ros1ChunkInfoEntry)
      chunk.messages += source.numberAt<std::uint32_t>(at + 4).value_or(0);
    chunks.push_back(chunk);
    return true;
  }

  bool readChunkIndex(ByteSource& source, const Ros1ChunkInfo& chunk, std::uint64_t& end) {
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

  bool readIndexData(ByteSource& source, const Ros1Record& record, std::uint32_t block) {
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

  void scan(ByteSource& source, std::uint64_t at) {
    topicOfConnection_.clear();
    // Messages of a recorder that died lie in no chunk.
    const std::uint32_t wholeFile = restart();
    bool whole = true;
    for (Ros1Record record; at < source.size() && whole; at = whole ? record.end : at) {
      const RecordState state = readRos1Record(source, at, record);
      whole = state == RecordState::whole;
      if (record.op == Ros1Op::chunk)
        whole = scanCut(record, whole);
      else if (whole && record.op == Ros1Op::connection)
        whole = addConnection(source, record);
      else if (whole && record.op == Ros1Op::message)
        addMessage(record, wholeFile, at);
      else
        whole = whole && record.op >= Ros1Op::bagHeader && record.op <= Ros1Op::chunkInfo;
    }
    warnOfScan(whole, at);
  }

  /// False where nothing can follow.
  bool scanCut(const Ros1Record& record, bool whole) {
    auto chunk = chunkOf(record);
    if (!chunk) return false;
    // A recorder that died has not written the size yet. Its messages follow, or its compressed bytes do.
    if (chunk->stored == 0 && chunk->compression == Compression::none) return true;
    chunk->whole = whole && chunk->stored != 0;
    if (!chunk->whole) {
      chunk->stored = blocks_.file().size() - record.data;
      if (chunk->compression == Compression::none) chunk->size = chunk->stored;
    }
    scanChunk(*chunk);
    return chunk->whole;
  }

  bool scanRecords(ByteSource& source, std::uint32_t block) override {
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

  void addMessage(const Ros1Record& record, std::uint32_t block, std::uint64_t offset) {
    const auto topic = topicOf(record);
    const auto time = ros1Time(record.field("time").value_or(""));
    if (topic && time)
      addPlace({*time, offset, block, *topic});
    else
      ++unknown_;
  }

  std::unordered_map<std::uint32_t, std::uint32_t> topicOfConnection_;
};

}  // namespace

std::unique_ptr<BagPart> openRos1Part(FileBytes file) {
  return std::make_unique<Ros1Part>(std::move(file));
}

}  // namespace estancia::ros
