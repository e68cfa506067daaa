// Bags of ROS 1 as recorders leave them, and as nobody should write them.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "ros/bag_contents.hpp"
#include "ros/bag_writer.hpp"
#include "support/errors.hpp"

namespace estancia::ros {
namespace {

using test::contentsOf;
using test::FailsWith;
using test::ros1Bag;
using test::ros1Field;
using test::ros1Record;
using testing::IsEmpty;

std::vector<test::WrittenMessage> ros1Drive() {
  std::vector<test::WrittenMessage> messages;
  for (int i = 0; i < 40; ++i) {
    const std::int64_t time = 1'500'000'000'000'000'000 + i * 1'000'000;
    messages.push_back({"/image", "sensor_msgs/Image", time, std::string(300 + i, static_cast<char>(i))});
    if (i % 4 == 0) messages.push_back({"/tf", "tf/tfMessage", time, "transform " + std::to_string(i)});
  }
  return messages;
}

class Ros1Bag : public testing::Test {
 protected:
  std::unique_ptr<Bag> open(const std::string& bytes) const {
    test::writeFile(folder_ / "drive.bag", bytes);
    return openBag(folder_ / "drive.bag");
  }
  std::unique_ptr<Bag> openWritten(const std::string& compression, bool index,
                                   bool messageIndex = true) const {
    return open(ros1Bag(
        ros1Drive(),
        {.compression = compression, .chunkBytes = 2000, .messageIndex = messageIndex, .index = index}));
  }
  test::ScratchFolder folder_;
};

TEST_F(Ros1Bag, IsReadByItsIndex) {
  const auto bag = openWritten("none", true);
  EXPECT_THAT(bag->warnings(), IsEmpty());
  ASSERT_EQ(bag->topics().size(), 2U);
  EXPECT_EQ(bag->topics()[0].type, "sensor_msgs/Image");
  EXPECT_EQ(bag->topics()[0].encoding, Encoding::ros1);
  EXPECT_EQ(bag->topics()[0].encodingName, "ros1");
  EXPECT_EQ(bag->messages().size(), 50U);
  EXPECT_EQ(test::bytesOf(*bag, 0), std::string(300, '\0'));
  EXPECT_EQ(test::bytesOf(*bag, 1), "transform 0");  // of the same time, as it was recorded
  EXPECT_THAT([&] { bag->read(50); }, FailsWith(ErrorCode::invalidInput));
}

TEST_F(Ros1Bag, WithoutAnIndexIsReadThrough) {
  const auto whole = contentsOf(*openWritten("none", true));
  for (const char* compression : {"none", "lz4", "bz2"}) {
    SCOPED_TRACE(compression);
    const auto unindexed = openWritten(compression, false);
    EXPECT_EQ(unindexed->warnings().size(), 1U);
    EXPECT_EQ(contentsOf(*unindexed), whole);
    // The index at the end tells of others that are missing.
    EXPECT_EQ(contentsOf(*openWritten(compression, true, false)), whole);
  }
}

// A recorder that is killed has not yet written the size of its last chunk.
TEST_F(Ros1Bag, TheChunkThatWasBeingWrittenIsRead) {
  const auto messages = ros1Drive();
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
  const std::string bytes = ros1Bag(ros1Drive(), {.chunkBytes = 2000});
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
}

TEST_F(Ros1Bag, ADamagedChunkCostsItsMessagesOnly) {
  for (const char* compression : {"lz4", "bz2"}) {
    SCOPED_TRACE(compression);
    for (const bool index : {true, false}) {
      std::string bytes =
          ros1Bag(ros1Drive(), {.compression = compression, .chunkBytes = 2000, .index = index});
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

}  // namespace
}  // namespace estancia::ros
