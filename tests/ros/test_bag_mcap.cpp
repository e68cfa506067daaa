// MCAP files as recorders leave them, and as nobody should write them.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <random>
#include <thread>

#include "ros/bag_contents.hpp"
#include "ros/bag_writer.hpp"
#include "support/errors.hpp"

namespace estancia::ros {
namespace {

using test::contentsOf;
using test::FailsWith;
using test::mcapBag;
using testing::IsEmpty;

std::vector<test::WrittenMessage> mcapDrive(std::size_t imageBytes = 300) {
  const std::string cdr("\0\1\0\0", 4);
  std::vector<test::WrittenMessage> messages;
  for (int i = 0; i < 40; ++i) {
    const std::int64_t time = 1'500'000'000'000'000'000 + i * 1'000'000;
    messages.push_back(
        {"/image", "sensor_msgs/msg/Image", time, cdr + std::string(imageBytes + i, static_cast<char>(i))});
    if (i % 4 == 0) messages.push_back({"/tf", "tf2_msgs/msg/TFMessage", time, cdr + "transform"});
  }
  return messages;
}

class McapBag : public testing::Test {
 protected:
  std::unique_ptr<Bag> open(const std::string& bytes) const {
    test::writeFile(folder_ / "drive.mcap", bytes);
    return openBag(folder_ / "drive.mcap");
  }
  test::ScratchFolder folder_;
};

TEST_F(McapBag, IsTheSameHoweverItIsWritten) {
  const auto whole = contentsOf(*open(mcapBag(mcapDrive())));
  EXPECT_EQ(whole.size(), 50U);
  for (const char* compression : {"none", "lz4", "zstd"})
    for (const std::size_t chunk : {0, 1, 2000, 1'000'000})
      for (const bool messageIndex : {true, false})
        for (const bool index : {true, false})
          for (const bool checksums : {true, false}) {
            const auto bag = open(mcapBag(mcapDrive(), {compression, chunk, messageIndex, index, checksums}));
            EXPECT_THAT(bag->warnings(), IsEmpty());
            ASSERT_EQ(contentsOf(*bag), whole) << compression << chunk << messageIndex << index << checksums;
          }
}

TEST_F(McapBag, MessagesOfOtherEncodingsAreNamed) {
  for (const auto& [name, encoding] : std::map<std::string, std::optional<Encoding>>{
           {"cdr", Encoding::cdr}, {"ros1", Encoding::ros1}, {"json", std::nullopt}}) {
    const auto bag = open(mcapBag(mcapDrive(), {.encoding = name}));
    EXPECT_EQ(bag->topics()[0].encodingName, name);
    EXPECT_EQ(bag->topics()[0].encoding, encoding);
  }
}

TEST_F(McapBag, AWrongChecksumCostsTheMessagesOfItsChunk) {
  // The first chunk begins behind the magic and a header of 16 bytes; its checksum behind three numbers.
  constexpr std::size_t kChecksum = 8 + 9 + 16 + 9 + 24;
  for (const char* compression : {"none", "lz4", "zstd"}) {
    SCOPED_TRACE(compression);
    std::string bytes = mcapBag(mcapDrive(), {.compression = compression, .chunkBytes = 2000});
    bytes[kChecksum] ^= 1;
    const auto bag = open(bytes);
    std::size_t unreadable = 0;
    const auto found = contentsOf(*bag, &unreadable);
    EXPECT_GT(found.size(), 30U);
    EXPECT_EQ(found.size() + unreadable, 50U);
    EXPECT_THAT([&] { bag->read(0); }, FailsWith(ErrorCode::corruptFile));
  }
}

TEST_F(McapBag, ASummaryThatLiesIsNotFollowed) {
  const auto messages = mcapDrive();
  const std::string bytes = mcapBag(messages, {.chunkBytes = 2000, .checksums = false});
  const auto whole = contentsOf(*open(bytes));
  const std::size_t summary = bytes.size() - 8 - 20;
  std::uint64_t begin = 0;
  std::memcpy(&begin, bytes.data() + summary, sizeof begin);
  // Whatever byte of it is another, messages are all there, or reading says that they are not.
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
  const auto bag = open(mcapBag(mcapDrive(3000), {.compression = "zstd", .chunkBytes = 10000}));
  const auto one = contentsOf(*bag);
  std::vector<test::BagContents> many(4);
  {
    std::vector<std::jthread> threads;
    for (test::BagContents& contents : many)
      threads.emplace_back([&bag, &contents] { contents = contentsOf(*bag); });
  }
  EXPECT_THAT(many, testing::Each(one));
}

}  // namespace
}  // namespace estancia::ros
