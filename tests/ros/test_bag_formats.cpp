// Bags of ROS 1 as recorders leave them, and damaged ones.
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>
#include <sqlite3.h>

#include <algorithm>
#include <cstring>
#include <random>
#include <thread>

#include "ros/bag_writer.hpp"
#include "support/errors.hpp"

namespace estancia::ros {
namespace {

namespace fs = std::filesystem;
using test::contentsOf;
using test::FailsWith;
using test::littleEndian;
using test::mcapBag;
using test::mcapRecord;
using test::ros1Bag;
using test::ros1Field;
using test::ros1Record;
using testing::IsEmpty;

/// Forty images, and a transform with each fourth; in CDR with its header.
std::vector<test::WrittenMessage> drive(bool isRos1, std::size_t imageBytes = 300) {
  const std::string cdr = isRos1 ? "" : std::string("\0\1\0\0", 4), types = isRos1 ? "" : "msg/";
  std::vector<test::WrittenMessage> messages;
  for (int i = 0; i < 40; ++i) {
    const std::int64_t time = 1'500'000'000'000'000'000 + i * 1'000'000;
    messages.push_back({"/image", "sensor_msgs/" + types + "Image", time,
                        cdr + std::string(imageBytes + i, static_cast<char>(i))});
    if (i % 4 == 0)
      messages.push_back({"/tf", isRos1 ? "tf/tfMessage" : "tf2_msgs/msg/TFMessage", time,
                          cdr + "transform " + std::to_string(i)});
  }
  return messages;
}
/// Writes a bag and opens it.
class WrittenBag : public testing::Test {
 protected:
  explicit WrittenBag(const char* name) : path_(folder_ / name) {}
  std::unique_ptr<Bag> open(const std::string& bytes) const {
    test::writeFile(path_, bytes);
    return openBag(path_);
  }
  /// Whether a bag of no messages that can be read is opened with a warning.
  bool isEmptyWithAWarning(const std::string& bytes) const {
    const auto bag = open(bytes);
    return bag->messages().empty() && !bag->warnings().empty();
  }
  test::ScratchFolder folder_;
  const fs::path path_;
};

class Ros1Bag : public WrittenBag {
 protected:
  Ros1Bag() : WrittenBag("drive.bag") {}
  std::unique_ptr<Bag> openWritten(const std::string& compression, bool index,
                                   bool messageIndex = true) const {
    return open(ros1Bag(
        drive(true),
        {.compression = compression, .chunkBytes = 2000, .messageIndex = messageIndex, .index = index}));
  }
};

TEST_F(Ros1Bag, IsReadByItsIndex) {
  const auto bag = openWritten("none", true);
  EXPECT_THAT(bag->warnings(), IsEmpty());
  ASSERT_EQ(bag->topics().size(), 2U);
  EXPECT_THAT(bag->topics()[0],
              testing::FieldsAre("/image", "sensor_msgs/Image", Encoding::ros1, "ros1", 40));
  EXPECT_EQ(bag->messages().size(), 50U);
  EXPECT_EQ(test::bytesOf(*bag, 0), std::string(300, '\0'));
  EXPECT_EQ(test::bytesOf(*bag, 1), "transform 0");  // equal times: in recorded order
  EXPECT_THAT([&] { bag->read(50); }, FailsWith(ErrorCode::invalidInput));
}

TEST_F(Ros1Bag, WithoutAnIndexIsReadThrough) {
  const auto whole = contentsOf(*openWritten("none", true));
  for (const char* compression : {"none", "lz4", "bz2"}) {
    SCOPED_TRACE(compression);
    const auto unindexed = openWritten(compression, false);
    EXPECT_EQ(unindexed->warnings().size(), 1U);
    EXPECT_EQ(contentsOf(*unindexed), whole);
    // The index at the end lists others that are missing.
    EXPECT_EQ(contentsOf(*openWritten(compression, true, false)), whole);
  }
}

// A recorder that is killed has not yet written the size of its last chunk.
TEST_F(Ros1Bag, TheChunkThatWasBeingWrittenIsRead) {
  const auto messages = drive(true);
  const auto whole = contentsOf(*openWritten("none", true));
  for (const char* compression : {"none", "lz4", "bz2"}) {
    SCOPED_TRACE(compression);
    std::string bytes =
        ros1Bag(messages, {.compression = compression, .messageIndex = false, .index = false});
    // The size, and the length of the data.
    bytes.replace(bytes.find("size=") + 5, 8, std::string(8, '\0'));
    EXPECT_EQ(contentsOf(*open(bytes)), whole);
    // And cut off in it: the blocks of bzip2 are longer than this.
    const auto cut = contentsOf(*open(bytes.substr(0, bytes.size() - 20)));
    if (std::string(compression) == "none") {
      EXPECT_EQ(cut.size(), whole.size() - 1);
    }
    EXPECT_TRUE(std::includes(whole.begin(), whole.end(), cut.begin(), cut.end()));
  }
}

TEST_F(Ros1Bag, AnIndexThatLiesIsNotFollowed) {
  const auto whole = contentsOf(*openWritten("none", true));
  const std::string bytes = ros1Bag(drive(true), {.chunkBytes = 2000});
  // Numbers in the index, each made larger: positions, connections, counts.
  for (const char* field : {"index_pos=", "chunk_count=", "conn_count=", "chunk_pos=", "ver=", "count="}) {
    SCOPED_TRACE(field);
    std::string lying = bytes;
    const std::size_t at = lying.find(field) + std::string(field).size();
    lying[at] = static_cast<char>(lying[at] + 1);
    const auto bag = open(lying);
    EXPECT_FALSE(bag->warnings().empty());
    EXPECT_EQ(contentsOf(*bag), whole);
  }
  // Whatever byte of it is another, messages are all there, or reading reports that they are not.
  for (std::size_t at = bytes.rfind("message_definition") - 200; at < bytes.size(); ++at) {
    SCOPED_TRACE(at);
    std::string lying = bytes;
    lying[at] = static_cast<char>(lying[at] ^ (at % 2 == 0 ? 1 : 0x51));
    std::size_t unreadable = 0;
    EXPECT_EQ(contentsOf(*open(lying), &unreadable).size() + unreadable, whole.size());
  }
}

// Records of a chunk, and the index behind it.
TEST_F(Ros1Bag, DamageCostsNoMoreThanWhatItHits) {
  for (const bool index : {true, false}) {
    const std::string bytes = ros1Bag(drive(true), {.chunkBytes = 500'000, .index = index});
    const auto whole = contentsOf(*open(bytes));
    for (std::size_t at = bytes.find("op=\x05"); at < bytes.find("transform 0") + 400; ++at) {
      if (bytes[at] == '\0') continue;  // most are pixels
      SCOPED_TRACE(at);
      std::string damaged = bytes;
      damaged[at] = static_cast<char>(damaged[at] ^ 0x11);
      const auto bag = open(damaged);
      std::size_t unreadable = 0, lost = 0;
      const auto found = contentsOf(*bag, &unreadable);
      for (const auto& message : whole) lost += found.contains(message) ? 0 : 1;
      EXPECT_TRUE(lost <= unreadable + 2 || !bag->warnings().empty()) << lost << " lost";
    }
  }
}

TEST_F(Ros1Bag, ADamagedChunkCostsItsMessagesOnly) {
  for (const char* compression : {"lz4", "bz2"}) {
    SCOPED_TRACE(compression);
    for (const bool index : {true, false}) {
      std::string bytes =
          ros1Bag(drive(true), {.compression = compression, .chunkBytes = 2000, .index = index});
      bytes[bytes.find("size=", bytes.find("size=") + 5) + 80] ^= 0x55;
      const auto bag = open(bytes);
      std::size_t unreadable = 0;
      const auto found = contentsOf(*bag, &unreadable);
      EXPECT_GT(found.size(), 30U);
      EXPECT_LT(found.size(), 50U);
      EXPECT_EQ(unreadable, index ? 50U - found.size() : 0U);
      EXPECT_EQ(bag->warnings().empty(), index);
    }
  }
}

TEST_F(Ros1Bag, WhatIsNoneIsRefused) {
  const std::string header = "#ROSBAG V2.0\n";
  EXPECT_THAT([&] { open(header); }, FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT([&] { open(header + std::string(100, '\xFF')); }, FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT([&] { open("#ROSBAG V1.2\n"); }, FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT(
      [&] {
        open(header +
             ros1Record(ros1Field("op", "\x03") + ros1Field("encryptor", "rosbag/AesCbcEncryptor"), ""));
      },
      FailsWith(ErrorCode::unsupportedFile));
}

class McapBag : public WrittenBag {
 protected:
  McapBag() : WrittenBag("drive.mcap") {}
};

TEST_F(McapBag, IsTheSameHoweverItIsWritten) {
  const auto whole = contentsOf(*open(mcapBag(drive(false))));
  EXPECT_EQ(whole.size(), 50U);
  for (const char* compression : {"none", "lz4", "zstd"})
    for (const std::size_t chunk : {0, 1, 2000, 1'000'000})
      for (const bool messageIndex : {true, false})
        for (const bool index : {true, false})
          for (const bool checksums : {true, false}) {
            const auto bag =
                open(mcapBag(drive(false), {compression, chunk, messageIndex, index, checksums}));
            EXPECT_THAT(bag->warnings(), IsEmpty());
            ASSERT_EQ(contentsOf(*bag), whole) << compression << chunk << messageIndex << index << checksums;
          }
}

TEST_F(McapBag, MessagesOfOtherEncodingsAreNamed) {
  for (const auto& [name, encoding] : std::map<std::string, std::optional<Encoding>>{
           {"cdr", Encoding::cdr}, {"ros1", Encoding::ros1}, {"json", std::nullopt}}) {
    const auto bag = open(mcapBag(drive(false), {.encoding = name}));
    EXPECT_EQ(bag->topics()[0].encodingName, name);
    EXPECT_EQ(bag->topics()[0].encoding, encoding);
  }
}

TEST_F(McapBag, AWrongChecksumCostsTheMessagesOfItsChunk) {
  // The first chunk begins behind the magic and a header of 16 bytes; its checksum behind three numbers.
  constexpr std::size_t checksum = 8 + 9 + 16 + 9 + 24;
  for (const char* compression : {"none", "lz4", "zstd"}) {
    SCOPED_TRACE(compression);
    std::string bytes = mcapBag(drive(false), {.compression = compression, .chunkBytes = 2000});
    bytes[checksum] ^= 1;
    const auto bag = open(bytes);
    std::size_t unreadable = 0;
    const auto found = contentsOf(*bag, &unreadable);
    EXPECT_GT(found.size(), 30U);
    EXPECT_EQ(found.size() + unreadable, 50U);
    EXPECT_THAT([&] { bag->read(0); }, FailsWith(ErrorCode::corruptFile));
  }
}

TEST_F(McapBag, ASummaryThatLiesIsNotFollowed) {
  const auto messages = drive(false);
  const std::string bytes = mcapBag(messages, {.chunkBytes = 2000, .checksums = false});
  const auto whole = contentsOf(*open(bytes));
  const std::size_t summary = bytes.size() - 8 - 20;
  std::uint64_t begin = 0;
  std::memcpy(&begin, bytes.data() + summary, sizeof begin);
  // Whatever byte of it is another, messages are all there, or reading reports that they are not.
  for (std::size_t at = begin; at < bytes.size(); ++at) {
    SCOPED_TRACE(at);
    std::string lying = bytes;
    lying[at] = static_cast<char>(lying[at] ^ 0x11);
    const auto bag = open(lying);
    std::size_t unreadable = 0;
    EXPECT_EQ(contentsOf(*bag, &unreadable).size() + unreadable, whole.size());
  }
}

// What a recorder has written when its robot is switched off.
TEST_F(McapBag, AChunkThatIsCutOffGivesItsBeginning) {
  std::vector<test::WrittenMessage> messages;
  std::mt19937 random(3);
  for (std::int64_t i = 0; i < 100; ++i) {
    std::string bytes(10000, '\0');
    for (char& byte : bytes) byte = static_cast<char>(random());
    messages.push_back({"/n", "std_msgs/msg/String", i, bytes});
  }
  for (const char* compression : {"none", "lz4", "zstd"}) {
    SCOPED_TRACE(compression);
    const std::string bytes =
        mcapBag(messages, {.compression = compression, .chunkBytes = 2'000'000, .encoding = "json"});
    const auto bag = open(bytes.substr(0, 800'000));
    EXPECT_EQ(bag->warnings().size(), 1U);
    // The compressed blocks have up to 128 KiB.
    EXPECT_GT(bag->messages().size(), 60U);
    EXPECT_LT(bag->messages().size(), 80U);
    for (std::size_t i = 0; i < bag->messages().size(); ++i)
      EXPECT_EQ(test::bytesOf(*bag, i), messages[i].bytes);
  }
}

TEST_F(McapBag, IsReadByManyThreadsAtOnce) {
  const auto bag = open(mcapBag(drive(false, 3000), {.compression = "zstd", .chunkBytes = 10000}));
  const auto one = contentsOf(*bag);
  std::vector<test::BagContents> many(4);
  {
    std::vector<std::jthread> threads;
    for (test::BagContents& contents : many)
      threads.emplace_back([&bag, &contents] { contents = contentsOf(*bag); });
  }
  EXPECT_THAT(many, testing::Each(one));
}

std::vector<test::WrittenMessage> sqliteDrive() {
  const std::string cdr("\0\1\0\0", 4);
  std::vector<test::WrittenMessage> messages;
  for (int i = 0; i < 40; ++i)
    messages.push_back(
        {i % 4 == 0 ? "/tf" : "/image", i % 4 == 0 ? "tf2_msgs/msg/TFMessage" : "sensor_msgs/msg/Image",
         1'500'000'000'000'000'000 + i, cdr + std::string(50 + i * 200, static_cast<char>('a' + i % 26))});
  return messages;
}

void change(const fs::path& path, const std::string& sql) {
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &database), SQLITE_OK);
  EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK)
      << sqlite3_errmsg(database);
  sqlite3_close(database);
}

class SqliteBag : public WrittenBag {
 protected:
  /// A name that would mean something in a URI.
  SqliteBag() : WrittenBag("drive 100%?mode=rw#1.db3") { test::writeSqliteBag(path_, sqliteDrive()); }
};

TEST_F(SqliteBag, IsReadAndLeftAsItIs) {
  const std::string before = test::readFile(path_);
  {
    const auto bag = openBag(path_);
    EXPECT_TRUE(isBag(path_));
    EXPECT_THAT(bag->warnings(), IsEmpty());
    EXPECT_EQ(contentsOf(*bag).size(), 40U);
    EXPECT_THAT(bag->topics()[1], testing::FieldsAre("/tf", "tf2_msgs/TFMessage", Encoding::cdr, "cdr", 10));
    EXPECT_EQ(test::bytesOf(*bag, 39), sqliteDrive()[39].bytes);
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_.path()), {}), 1);
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_.path()), {}), 1);
  EXPECT_EQ(test::readFile(path_), before);
}

TEST_F(SqliteBag, MessagesThatWaitBesideItAreTold) {
  change(path_, "PRAGMA journal_mode = WAL");
  test::writeFile(path_.string() + "-wal", std::string(100, 'w'));
  const auto bag = openBag(path_);
  EXPECT_EQ(bag->warnings().size(), 1U);
  EXPECT_EQ(contentsOf(*bag).size(), 40U);
}

TEST_F(SqliteBag, MessagesOfNoTopicAreTold) {
  change(path_, "DELETE FROM topics WHERE name = '/tf'");
  const auto bag = openBag(path_);
  EXPECT_EQ(bag->warnings().size(), 1U);
  EXPECT_EQ(contentsOf(*bag).size(), 30U);
}

TEST_F(SqliteBag, ADamagedPageCostsItsMessagesOnly) {
  std::string bytes = test::readFile(path_);
  // Each page that begins as a leaf of a table; pages of this file have 4096 bytes.
  std::size_t leaves = 0, survived = 0;
  for (std::size_t page = 1; page < bytes.size() / 4096; ++page) {
    if (bytes[page * 4096] != 13) continue;
    std::string damaged = bytes;
    std::fill_n(damaged.begin() + static_cast<std::ptrdiff_t>(page * 4096), 4096, '\xEE');
    test::writeFile(path_, damaged);
    std::unique_ptr<Bag> bag;
    test::caught([&] { bag = openBag(path_); });
    if (!bag) continue;  // the page of the topics
    ++leaves;
    std::size_t unreadable = 0;
    const std::size_t found = contentsOf(*bag, &unreadable).size();
    SCOPED_TRACE(page);
    EXPECT_LT(found, 40U);
    EXPECT_FALSE(bag->warnings().empty());
    if (found > 0) ++survived;
  }
  EXPECT_GT(leaves, 5U);
  EXPECT_EQ(survived, leaves);
}

TEST_F(SqliteBag, WhatIsNoneIsRefused) {
  for (const char* sql :
       {"ALTER TABLE messages RENAME TO hidden;"
        "CREATE VIEW messages AS WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n)"
        " SELECT i AS id, 1 AS topic_id, i AS timestamp, 'x' AS data FROM n",
        "ALTER TABLE topics ADD COLUMN computed TEXT AS (hex(zeroblob(1000000)))", "DROP TABLE topics"}) {
    fs::remove(path_);
    test::writeSqliteBag(path_, sqliteDrive());
    change(path_, sql);
    EXPECT_THAT([&] { openBag(path_); }, FailsWith(ErrorCode::unsupportedFile)) << sql;
  }
  test::writeFile(path_, std::string("SQLite format 3\0", 16) + std::string(5000, '\x77'));
  EXPECT_THAT([&] { openBag(path_); }, FailsWith(ErrorCode::malformedFile));
  test::writeFile(path_, std::string("SQLite format 3\0", 16));
  EXPECT_THAT([&] { openBag(path_); }, FailsWith(ErrorCode::malformedFile));
}

TEST_F(SqliteBag, AFileThatShrinksIsAnError) {
  const auto bag = openBag(path_);
  fs::resize_file(path_, 8192);
  EXPECT_THAT([&] { bag->read(39); }, FailsWith(ErrorCode::truncatedFile));
}

std::string mcapOfOneChunk(const std::string& compression, std::uint64_t size, std::uint64_t stored,
                           const std::string& data) {
  const std::string name = littleEndian(static_cast<std::uint32_t>(compression.size())) + compression;
  return std::string("\x89MCAP0\r\n", 8) + mcapRecord(1, std::string(8, '\0')) +
         mcapRecord(6, std::string(16, '\0') + littleEndian(size) + littleEndian<std::uint32_t>(0) + name +
                           littleEndian(stored) + data) +
         mcapRecord(15, std::string(4, '\0'));
}

TEST_F(McapBag, ChunksThatCannotBeAreRefused) {
  const std::string zstd = test::compressed(std::string(100, 'x'), "zstd");
  const auto isRefused = [&](const char* compression, std::uint64_t size, std::uint64_t stored) {
    return isEmptyWithAWarning(mcapOfOneChunk(compression, size, stored, zstd));
  };
  for (const std::uint64_t size : {1ULL << 40U, 1ULL << 30U, 99ULL})
    EXPECT_TRUE(isRefused("zstd", size, zstd.size())) << size;
  EXPECT_TRUE(isRefused("zstd", 100, zstd.size() + 1));
  EXPECT_TRUE(isRefused("lzma", 100, zstd.size()));
  EXPECT_TRUE(isEmptyWithAWarning(mcapOfOneChunk("", ~0ULL, ~0ULL, "")));
}

std::string bagOfOneChunk(const std::string& compression, std::uint32_t size, const std::string& data) {
  return "#ROSBAG V2.0\n" + ros1Record(ros1Field("op", "\x03"), "") +
         ros1Record(ros1Field("op", "\x05") + ros1Field("compression", compression) +
                        ros1Field("size", littleEndian(size)),
                    data);
}

TEST_F(Ros1Bag, ChunksThatCannotBeAreRefused) {
  const std::string lz4 = test::compressed(std::string(100, 'x'), "lz4");
  // More than 1 GiB, more than lz4 can, other sizes.
  for (const std::uint32_t size : {0xFFFF'FFFFU, 900'000'000U, 99U, 101U})
    EXPECT_TRUE(isEmptyWithAWarning(bagOfOneChunk("lz4", size, lz4))) << size;
  for (const char* other : {"bz2", "rot13", "none"})
    EXPECT_TRUE(isEmptyWithAWarning(bagOfOneChunk(other, 100, lz4))) << other;
}

}  // namespace
}  // namespace estancia::ros
