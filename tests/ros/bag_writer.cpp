// SPDX-License-Identifier: Apache-2.0
#include "ros/bag_writer.hpp"

#include <bzlib.h>
#include <lz4frame.h>
#include <sqlite3.h>
#include <zlib.h>
#include <zstd.h>

#include <map>
#include <stdexcept>

namespace estancia::test {
namespace {

std::string text(const std::string& value) {
  return littleEndian<std::uint32_t>(static_cast<std::uint32_t>(value.size())) + value;
}

std::uint32_t crcOf(const std::string& bytes) {
  return static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

std::string ros1Time(std::int64_t time) {
  return littleEndian(static_cast<std::uint32_t>(time / 1'000'000'000)) +
         littleEndian(static_cast<std::uint32_t>(time % 1'000'000'000));
}

/// Numbers of topics, in order of their first message.
template <class Number>
std::pair<Number, bool> numberOf(std::map<std::string, Number>& numbers, const WrittenMessage& message,
                                 Number first) {
  const auto [at, added] =
      numbers.emplace(message.topic + "\n" + message.type, static_cast<Number>(first + numbers.size()));
  return {at->second, added};
}

class Ros1Writer {
 public:
  explicit Ros1Writer(const BagWriting& writing) : writing_(writing) {
    bag_ = "#ROSBAG V2.0\n";
    bag_ += header(0);
  }

  void add(const WrittenMessage& message) {
    const auto [number, added] = numberOf<std::uint32_t>(numbers_, message, 0);
    const std::string connection = ros1Field("conn", littleEndian(number));
    if (added) {
      const std::string record =
          ros1Record(ros1Field("op", "\x07") + connection + ros1Field("topic", message.topic),
                     ros1Field("topic", message.topic) + ros1Field("message_definition", "int32 n") +
                         ros1Field("type", message.type));
      connections_ += record;
      chunk_ += record;
    }
    entries_[number] += ros1Time(message.time) + littleEndian(static_cast<std::uint32_t>(chunk_.size()));
    chunk_ += ros1Record(ros1Field("op", "\x02") + connection + ros1Field("time", ros1Time(message.time)),
                         message.bytes);
    if (chunk_.size() >= writing_.chunkBytes) closeChunk();
  }

  std::string close() {
    if (!chunk_.empty()) closeChunk();
    if (!writing_.index) return bag_;
    const std::uint64_t index = bag_.size();
    return bag_.replace(13, header(0).size(), header(index)) + connections_ + infos_;
  }

 private:
  std::string header(std::uint64_t index) const {
    return ros1Record(ros1Field("op", "\x03") + ros1Field("index_pos", littleEndian(index)) +
                          ros1Field("conn_count", littleEndian(static_cast<std::uint32_t>(numbers_.size()))) +
                          ros1Field("chunk_count", littleEndian(chunks_)),
                      std::string(100, ' '));
  }

  void closeChunk() {
    const std::uint64_t at = bag_.size();
    bag_ += ros1Record(ros1Field("op", "\x05") + ros1Field("compression", writing_.compression) +
                           ros1Field("size", littleEndian(static_cast<std::uint32_t>(chunk_.size()))),
                       compressed(chunk_, writing_.compression));
    std::string counts;
    for (const auto& [number, entries] : entries_) {
      const std::string count = littleEndian(static_cast<std::uint32_t>(entries.size() / 12));
      if (writing_.messageIndex)
        bag_ += ros1Record(ros1Field("op", "\x04") + ros1Field("ver", littleEndian<std::uint32_t>(1)) +
                               ros1Field("conn", littleEndian(number)) + ros1Field("count", count),
                           entries);
      counts += littleEndian(number) + count;
    }
    infos_ += ros1Record(ros1Field("op", "\x06") + ros1Field("ver", littleEndian<std::uint32_t>(1)) +
                             ros1Field("chunk_pos", littleEndian(at)) + ros1Field("start_time", ros1Time(0)) +
                             ros1Field("end_time", ros1Time(0)) +
                             ros1Field("count", littleEndian(static_cast<std::uint32_t>(entries_.size()))),
                         counts);
    ++chunks_;
    chunk_.clear();
    entries_.clear();
  }

  BagWriting writing_;
  std::string bag_, chunk_, connections_, infos_;
  std::uint32_t chunks_ = 0;
  std::map<std::string, std::uint32_t> numbers_;
  std::map<std::uint32_t, std::string> entries_;
};

class McapWriter {
 public:
  explicit McapWriter(const BagWriting& writing) : writing_(writing) {
    bag_ = magic() + mcapRecord(1, text("ros2") + text("test"));
  }

  void add(const WrittenMessage& message) {
    const auto [number, added] = numberOf<std::uint16_t>(numbers_, message, 1);
    std::string& to = writing_.chunkBytes == 0 ? bag_ : chunk_;
    if (added) {
      const std::string definition =
          mcapRecord(3, littleEndian(number) + text(message.type) + text("ros2msg") + text("int32 n")) +
          mcapRecord(4, littleEndian(number) + littleEndian(number) + text(message.topic) +
                            text(writing_.encoding) + text(""));
      definitions_ += definition;
      to += definition;
    }
    entries_[number] += littleEndian(message.time) + littleEndian(static_cast<std::uint64_t>(chunk_.size()));
    to += mcapRecord(5, littleEndian(number) + littleEndian(count_++) + littleEndian(message.time) +
                            littleEndian(message.time) + message.bytes);
    if (writing_.chunkBytes != 0 && chunk_.size() >= writing_.chunkBytes) closeChunk();
  }

  std::string close() {
    if (!chunk_.empty()) closeChunk();
    bag_ += mcapRecord(15, littleEndian<std::uint32_t>(0));
    std::uint64_t begin = 0;
    std::string summary;
    if (writing_.index) {
      begin = bag_.size();
      summary =
          definitions_ + indexes_ +
          mcapRecord(11, littleEndian<std::uint64_t>(count_) + std::string(2 + 4 * 4 + 8 * 2 + 4, '\0'));
    }
    std::string footer = mcapRecord(2, littleEndian(begin) + littleEndian<std::uint64_t>(0) + "crc.");
    footer.resize(footer.size() - 4);
    footer += littleEndian(writing_.checksums && begin != 0 ? crcOf(summary + footer) : 0U);
    return bag_ + summary + footer + magic();
  }

 private:
  static std::string magic() { return {"\x89MCAP0\r\n", 8}; }

  void closeChunk() {
    const std::uint64_t at = bag_.size();
    const std::string name = writing_.compression == "none" ? "" : writing_.compression;
    const std::string bytes = compressed(chunk_, writing_.compression);
    bag_ += mcapRecord(6, std::string(16, '\0') + littleEndian<std::uint64_t>(chunk_.size()) +
                              littleEndian(writing_.checksums ? crcOf(chunk_) : 0U) + text(name) +
                              littleEndian<std::uint64_t>(bytes.size()) + bytes);
    const std::uint64_t end = bag_.size();
    if (writing_.messageIndex)
      for (const auto& [number, entries] : entries_)
        bag_ += mcapRecord(7, littleEndian(number) + text(entries));
    indexes_ += mcapRecord(8, std::string(16, '\0') + littleEndian(at) + littleEndian(end - at) + text("") +
                                  littleEndian<std::uint64_t>(bag_.size() - end) + text(name) +
                                  littleEndian<std::uint64_t>(bytes.size()) +
                                  littleEndian<std::uint64_t>(chunk_.size()));
    chunk_.clear();
    entries_.clear();
  }

  BagWriting writing_;
  std::string bag_, chunk_, definitions_, indexes_;
  std::uint32_t count_ = 0;
  std::map<std::string, std::uint16_t> numbers_;
  std::map<std::uint16_t, std::string> entries_;
};

void execute(sqlite3* database, const std::string& sql) {
  if (sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK)
    throw std::runtime_error(sqlite3_errmsg(database));
}

}  // namespace

std::string compressed(const std::string& bytes, const std::string& compression) {
  if (compression == "none") return bytes;
  std::string out;
  if (compression == "lz4") {
    // With a checksum at the end, as roslz4 does.
    LZ4F_preferences_t preferences{};
    preferences.frameInfo.contentChecksumFlag = LZ4F_contentChecksumEnabled;
    out.resize(LZ4F_compressFrameBound(bytes.size(), &preferences));
    out.resize(LZ4F_compressFrame(out.data(), out.size(), bytes.data(), bytes.size(), &preferences));
  } else if (compression == "zstd") {
    out.resize(ZSTD_compressBound(bytes.size()));
    out.resize(ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), 1));
  } else if (compression == "bz2") {
    auto size = static_cast<unsigned>(bytes.size() + bytes.size() / 50 + 600);
    out.resize(size);
    BZ2_bzBuffToBuffCompress(out.data(), &size, const_cast<char*>(bytes.data()),
                             static_cast<unsigned>(bytes.size()), 9, 0, 0);
    out.resize(size);
  } else {
    return bytes;
  }
  return out;
}

std::string ros1Field(const std::string& name, const std::string& value) {
  return text(name + "=" + value);
}

std::string ros1Record(const std::string& header, const std::string& data) {
  return text(header) + text(data);
}

std::string mcapRecord(unsigned char code, const std::string& content) {
  return std::string(1, static_cast<char>(code)) + littleEndian<std::uint64_t>(content.size()) + content;
}

std::string ros1Bag(const std::vector<WrittenMessage>& messages, const BagWriting& writing) {
  Ros1Writer writer(writing);
  for (const WrittenMessage& message : messages) writer.add(message);
  return writer.close();
}

std::string mcapBag(const std::vector<WrittenMessage>& messages, const BagWriting& writing) {
  McapWriter writer(writing);
  for (const WrittenMessage& message : messages) writer.add(message);
  return writer.close();
}

void writeSqliteBag(const std::filesystem::path& path, const std::vector<WrittenMessage>& messages) {
  sqlite3* database = nullptr;
  if (sqlite3_open(path.c_str(), &database) != SQLITE_OK)
    throw std::runtime_error("cannot write " + path.string());
  execute(database,
          "BEGIN; CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,"
          " serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);"
          "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL,"
          " timestamp INTEGER NOT NULL, data BLOB NOT NULL);"
          "CREATE INDEX timestamp_idx ON messages (timestamp ASC);");
  sqlite3_stmt* insert = nullptr;
  sqlite3_prepare_v2(database, "INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)", -1,
                     &insert, nullptr);
  std::map<std::string, std::uint32_t> numbers;
  for (const WrittenMessage& message : messages) {
    const auto [number, added] = numberOf<std::uint32_t>(numbers, message, 1);
    if (added)
      execute(database, "INSERT INTO topics VALUES (" + std::to_string(number) + ", '" + message.topic +
                            "', '" + message.type + "', 'cdr', '')");
    sqlite3_bind_int64(insert, 1, number);
    sqlite3_bind_int64(insert, 2, message.time);
    sqlite3_bind_blob64(insert, 3, message.bytes.data(), message.bytes.size(), SQLITE_STATIC);
    sqlite3_step(insert);
    sqlite3_reset(insert);
  }
  sqlite3_finalize(insert);
  execute(database, "COMMIT");
  sqlite3_close(database);
}

}  // namespace estancia::test
