// Which files are a bag: folders, split bags, files that are compressed as a whole.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <vector>

#include "ros/bag_contents.hpp"
#include "ros/bag_writer.hpp"
#include "support/errors.hpp"

namespace estancia::ros {
namespace {

namespace fs = std::filesystem;
using test::contentsOf;
using test::FailsWith;
using test::writeFile;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// Ten messages, the first at this time.
std::vector<test::WrittenMessage> part(std::int64_t begin) {
  std::vector<test::WrittenMessage> messages;
  for (std::int64_t i = 0; i < 10; ++i)
    messages.push_back(
        {"/n", "std_msgs/msg/Int64", begin + i, std::string("\0\1\0\0", 4) + std::to_string(begin + i)});
  return messages;
}

std::string metadata(const std::string& files) {
  return "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: mcap\n  relative_file_paths:\n" +
         files + "  duration:\n    nanoseconds: 1\n  compression_format: \"\"\n";
}

class BagFolder : public testing::Test {
 protected:
  void SetUp() override {
    writeFile(bag_ / "drive_0.mcap", test::mcapBag(part(100)));
    writeFile(bag_ / "drive_1.mcap", test::mcapBag(part(200)));
    writeFile(bag_ / "drive_2.mcap", test::mcapBag(part(300)));
  }
  test::ScratchFolder scratch_;
  fs::path bag_ = scratch_ / "drive";
};

TEST_F(BagFolder, TheMetadataTellsWhatBelongsToIt) {
  writeFile(bag_ / "metadata.yaml", metadata("    - drive_1.mcap\n    - \"drive_0.mcap\"\n"));
  EXPECT_EQ(openBag(bag_)->messages().size(), 20U);
  // The first format of rosbag2.
  writeFile(bag_ / "metadata.yaml", metadata("    - drive/drive_1.mcap\n"));
  EXPECT_EQ(openBag(bag_)->messages().size(), 10U);
  EXPECT_THAT(openBag(bag_)->warnings(), IsEmpty());
}

TEST_F(BagFolder, APartThatIsMissingOrDamagedIsTold) {
  writeFile(bag_ / "metadata.yaml", metadata("    - drive_0.mcap\n    - drive_5.mcap\n    - drive_2.mcap\n"));
  EXPECT_THAT(openBag(bag_)->warnings(), ElementsAre(HasSubstr("drive_5.mcap")));
  EXPECT_EQ(openBag(bag_)->messages().size(), 20U);
  fs::remove(bag_ / "metadata.yaml");
  writeFile(bag_ / "drive_1.mcap", "no bag");
  EXPECT_THAT(openBag(bag_)->warnings(), ElementsAre(HasSubstr("drive_1.mcap")));
  EXPECT_EQ(openBag(bag_)->messages().size(), 20U);
  writeFile(bag_ / "drive_0.mcap", "");
  writeFile(bag_ / "drive_2.mcap", "no bag");
  EXPECT_THAT([&] { openBag(bag_); }, FailsWith(ErrorCode::unsupportedFile));
}

TEST_F(BagFolder, TheMetadataNeverLeadsOutOfIt) {
  writeFile(scratch_ / "secret.mcap", test::mcapBag(part(900)));
  const std::vector<std::string> paths{"../secret.mcap", (scratch_ / "secret.mcap").string(), "..", ".",
                                       "\"\""};
  for (const std::string& path : paths) {
    writeFile(bag_ / "metadata.yaml", metadata("    - drive_0.mcap\n    - " + path + "\n"));
    const auto bag = openBag(bag_);
    EXPECT_EQ(bag->messages().size(), 10U);
    EXPECT_EQ(bag->warnings().size(), 1U);
  }
}

TEST_F(BagFolder, OfSeveralFormatsOrNoneIsRefused) {
  writeFile(bag_ / "other.bag", test::ros1Bag(part(100)));
  EXPECT_THAT([&] { openBag(bag_); }, FailsWith(ErrorCode::unsupportedFile));
  const fs::path empty = scratch_ / "empty";
  fs::create_directories(empty);
  EXPECT_THAT([&] { openBag(empty); }, FailsWith(ErrorCode::unsupportedFile));
  EXPECT_FALSE(isBag(empty));
  writeFile(empty / "metadata.yaml", metadata("    - gone.mcap\n"));
  EXPECT_THAT([&] { openBag(empty); }, FailsWith(ErrorCode::fileNotFound));
}

TEST_F(BagFolder, OfImagesIsNoBagThoughOneLiesBesideThem) {
  const fs::path images = scratch_ / "images";
  writeFile(images / "1.png", "png");
  writeFile(images / "source.bag", test::ros1Bag(part(100)));
  EXPECT_FALSE(isBag(images));
  fs::remove(images / "1.png");
  writeFile(images / "source_1.bag", test::ros1Bag(part(200)));
  EXPECT_TRUE(isBag(images));
  EXPECT_EQ(openBag(images)->messages().size(), 20U);
}

TEST_F(BagFolder, WhatIsNoFileIsRefusedAtOnce) {
  EXPECT_THAT([&] { openBag(scratch_ / "none.mcap"); }, FailsWith(ErrorCode::fileNotFound));
  writeFile(scratch_ / "text.mcap", "words");
  EXPECT_THAT([&] { openBag(scratch_ / "text.mcap"); }, FailsWith(ErrorCode::unsupportedFile));
  // The pipe has no writer: waiting for one would never end.
  ASSERT_EQ(mkfifo((scratch_ / "pipe.mcap").c_str(), 0600), 0);
  EXPECT_THAT([&] { openBag(scratch_ / "pipe.mcap"); }, FailsWith(ErrorCode::unsupportedFile));
  for (const char* file : {"none.mcap", "text.mcap", "pipe.mcap"})
    EXPECT_FALSE(isBag(scratch_ / file)) << file;
}

class CompressedBag : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(temporary_);
    setenv("TMPDIR", temporary_.c_str(), 1);
  }
  void TearDown() override { unsetenv("TMPDIR"); }
  fs::path compress(const std::string& name, const std::string& bytes) {
    writeFile(scratch_ / (name + ".zstd"), test::compressed(bytes, "zstd"));
    return scratch_ / (name + ".zstd");
  }
  test::ScratchFolder scratch_;
  fs::path temporary_ = scratch_ / "temporary";
};

TEST_F(CompressedBag, IsReadAndLeavesNothingBehind) {
  const fs::path sqlite = scratch_ / "a.db3";
  test::writeSqliteBag(sqlite, part(100));
  const auto whole = contentsOf(*openBag(sqlite));
  for (const fs::path& path :
       {compress("a.db3", test::readFile(sqlite)), compress("b.mcap", test::mcapBag(part(100)))}) {
    EXPECT_TRUE(isBag(path));
    const auto bag = openBag(path);
    EXPECT_THAT(bag->warnings(), IsEmpty());
    EXPECT_TRUE(fs::is_empty(temporary_));
    EXPECT_EQ(contentsOf(*bag), whole);
  }
}

TEST_F(CompressedBag, CutOffGivesItsBeginning) {
  std::vector<test::WrittenMessage> messages;
  std::uint32_t random = 1;
  for (std::int64_t i = 0; i < 3000; ++i) {
    std::string bytes("\0\1\0\0", 4);
    for (int k = 0; k < 200; ++k) bytes += static_cast<char>((random = random * 1664525 + 1013904223) >> 24U);
    messages.push_back({"/n", "std_msgs/msg/Int64", i, bytes});
  }
  const fs::path path = compress("a.mcap", test::mcapBag(messages, {.chunkBytes = 20000}));
  const auto whole = contentsOf(*openBag(path));
  const std::string bytes = test::readFile(path);
  writeFile(path, bytes.substr(0, bytes.size() / 2));
  const auto bag = openBag(path);
  EXPECT_FALSE(bag->warnings().empty());
  EXPECT_GT(bag->messages().size(), 500U);
  const auto found = contentsOf(*bag);
  EXPECT_TRUE(std::includes(whole.begin(), whole.end(), found.begin(), found.end()));
  writeFile(path, bytes.substr(0, 10));
  EXPECT_THAT([&] { openBag(path); }, FailsWith(ErrorCode::corruptFile));
}

TEST_F(CompressedBag, OfSomethingElseIsRefused) {
  const fs::path path = compress("text", "words and words");
  EXPECT_FALSE(isBag(path));
  EXPECT_THAT([&] { openBag(path); }, FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT([&] { openBag(compress("twice.mcap", test::readFile(path))); },
              FailsWith(ErrorCode::unsupportedFile));
  setenv("TMPDIR", (scratch_ / "missing").c_str(), 1);
  EXPECT_THAT([&] { openBag(path); }, FailsWith(ErrorCode::fileUnwritable));
}

TEST_F(BagFolder, APartThatIsDamagedIsTold) {
  writeFile(bag_ / "drive_1.mcap", "no bag");
  const auto bag = openBag(bag_);
  EXPECT_THAT(bag->warnings(), testing::SizeIs(1));
  EXPECT_EQ(bag->messages().size(), 20U);
  writeFile(bag_ / "drive_0.mcap", "");
  writeFile(bag_ / "drive_2.mcap", "no bag");
  EXPECT_THAT([&] { openBag(bag_); }, FailsWith(ErrorCode::unsupportedFile));
}

TEST_F(BagFolder, APartThatIsMissingIsTold) {
  writeFile(bag_ / "metadata.yaml", metadata("    - drive_0.mcap\n    - drive_5.mcap\n    - drive_2.mcap\n"));
  const auto bag = openBag(bag_);
  EXPECT_THAT(bag->warnings(), testing::SizeIs(1));
  EXPECT_EQ(bag->messages().size(), 20U);
}

}  // namespace
}  // namespace estancia::ros
