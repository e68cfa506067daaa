// Bags that others have recorded, split or compressed as a whole: all that is in them is found.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <algorithm>
#include <random>
#include <vector>

#include "estancia/core/digest.hpp"
#include "estancia/ros/bag.hpp"
#include "ros/bag_writer.hpp"
#include "support/errors.hpp"

namespace estancia::ros {
namespace {

namespace fs = std::filesystem;
using test::bytesOf;
using test::contentsOf;
using test::countsOf;
using test::FailsWith;
using test::writeFile;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

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

/// Both hold the same, message by message; their stamps are others when they were recorded at other times.
void expectEqualBags(const Bag& a, const Bag& b, bool sameTimes = true) {
  ASSERT_EQ(a.messages().size(), b.messages().size());
  ASSERT_EQ(a.topics().size(), b.topics().size());
  for (std::size_t i = 0; i < a.topics().size(); ++i) {
    const auto& [name, type, encoding, encodingName, messages] = b.topics()[i];
    EXPECT_THAT(a.topics()[i], testing::FieldsAre(name, type, encoding, encodingName, messages));
  }
  for (std::size_t i = 0; i < a.messages().size(); ++i) {
    ASSERT_EQ(a.messages()[i].topic, b.messages()[i].topic) << i;
    ASSERT_EQ(bytesOf(a, i).size(), bytesOf(b, i).size()) << i;
    if (!sameTimes) continue;
    ASSERT_EQ(a.messages()[i].time, b.messages()[i].time) << i;
    ASSERT_EQ(bytesOf(a, i), bytesOf(b, i)) << i;
  }
}

class BagData : public testing::Test {
 protected:
  void SetUp() override {
    data_ = test::findData("robot_bags");
    ESTANCIA_NEEDS(data_, "no robot_bags");
  }
  std::unique_ptr<Bag> open(const std::string& file) const {
    auto bag = openBag(*data_ / file);
    EXPECT_THAT(bag->warnings(), IsEmpty()) << file;
    EXPECT_TRUE(isBag(*data_ / file)) << file;
    EXPECT_TRUE(std::is_sorted(bag->messages().begin(), bag->messages().end(),
                               [](const auto& a, const auto& b) { return a.time < b.time; }));
    return bag;
  }
  std::optional<fs::path> data_;
};

TEST_F(BagData, BagsOfEachCompressionAreEqual) {
  const auto ros1 = open("wire/example_none.bag"), ros2 = open("wire/chunks_none.mcap");
  EXPECT_THAT(ros1->messages(), SizeIs(8647));
  expectEqualBags(*ros1, *open("wire/example_lz4.bag"));
  expectEqualBags(*ros1, *open("wire/example_bz2.bag"));
  EXPECT_GT(ros2->messages().size(), 0U);
  expectEqualBags(*ros2, *open("wire/chunks_lz4.mcap"));
  expectEqualBags(*ros2, *open("wire/chunks_zstd.mcap"));
}

TEST_F(BagData, AnOfficeHasImagesOfTwoCamerasAndOdometry) {
  const auto bag = open("camera/office_fisheye_ros1.bag");
  EXPECT_THAT(bag->messages(), SizeIs(50));
  auto counts = countsOf(*bag);
  EXPECT_EQ(counts["/camera/fisheye1/image_raw"], 3U);
  EXPECT_EQ(counts["/camera/odom/sample"], 19U);
  for (std::size_t i = 0; i < bag->messages().size(); ++i)
    if (bag->topics()[bag->messages()[i].topic].type == "sensor_msgs/Image") {
      EXPECT_GT(bytesOf(*bag, i).size(), 848U * 800U);
    }
}

TEST_F(BagData, EveryTypeIsTheSameInSqliteAndMcap) {
  const auto sqlite = open("wire/all_types.db3");
  EXPECT_THAT(sqlite->topics(), SizeIs(94));
  EXPECT_THAT(sqlite->messages(), SizeIs(188));
  expectEqualBags(*sqlite, *open("wire/all_types.mcap"), false);
}

TEST_F(BagData, TransformsAreThereInBothFormats) {
  const auto ros1 = open("odometry/tf.bag"), ros2 = open("odometry/tf.db3");
  EXPECT_THAT(ros2->messages(), SizeIs(518));
  EXPECT_EQ(countsOf(*ros1), countsOf(*ros2));
  EXPECT_EQ(ros2->topics().front().type, "tf2_msgs/TFMessage");
  for (std::size_t i = 0; i < ros1->messages().size(); ++i)
    ASSERT_EQ(ros1->messages()[i].time, ros2->messages()[i].time);
}

TEST_F(BagData, MessagesThatRosbag2HasCompressedAreDecompressed) {
  const auto bag = open("camera/soccer_zstd_messages.mcap");
  EXPECT_EQ(countsOf(*bag)["/camera/image_raw"], 2U);
  for (std::size_t i = 0; i < bag->messages().size(); ++i) {
    const std::string bytes = bytesOf(*bag, i);
    EXPECT_EQ(bytes.substr(0, 2), std::string("\0\1", 2));
    if (bag->topics()[bag->messages()[i].topic].name == "/camera/image_raw") {
      EXPECT_GT(bytes.size(), 640U * 480U * 3U);
    }
  }
}

// Messages of large files without compression are read one by one.
TEST(LargeBag, MessagesAreReadWithoutTheirChunk) {
  std::vector<test::WrittenMessage> messages;
  for (std::int64_t i = 0; i < 20; ++i) {
    messages.push_back(
        {"/image", "sensor_msgs/msg/Image", 2 * i, std::string(1'000'000, static_cast<char>(i))});
    messages.push_back({"/tf", "tf2_msgs/msg/TFMessage", 2 * i + 1, std::to_string(i)});
  }
  const test::ScratchFolder folder;
  test::writeFile(folder / "a.bag", test::ros1Bag(messages, {.chunkBytes = 100'000'000}));
  test::writeFile(folder / "b.mcap",
                  test::mcapBag(messages, {.chunkBytes = 100'000'000, .checksums = false}));
  test::writeFile(folder / "c.mcap", test::mcapBag(messages, {.chunkBytes = 0}));
  for (const char* file : {"a.bag", "b.mcap", "c.mcap"}) {
    SCOPED_TRACE(file);
    const auto bag = openBag(folder / file);
    EXPECT_THAT(bag->warnings(), IsEmpty());
    ASSERT_THAT(bag->messages(), SizeIs(messages.size()));
    for (std::size_t i = 0; i < messages.size(); ++i) ASSERT_EQ(bytesOf(*bag, i), messages[i].bytes);
    fs::resize_file(folder / file, 5'000'000);
    EXPECT_EQ(bytesOf(*bag, 1), "0");
    EXPECT_THAT([&] { bag->read(30); }, test::FailsWith(ErrorCode::truncatedFile));
  }
}

TEST_F(BagData, PartsInAFolderAreOneBag) {
  const auto first = open("wire/split_0.mcap"), second = open("wire/split_1.mcap");
  const test::ScratchFolder folder;
  // Their names do not give their order.
  fs::copy(*data_ / "wire/split_0.mcap", folder / "b.mcap");
  fs::copy(*data_ / "wire/split_1.mcap", folder / "a.mcap");
  const auto both = openBag(folder.path());
  EXPECT_TRUE(isBag(folder.path()));
  EXPECT_THAT(both->warnings(), IsEmpty());
  const std::size_t count = first->messages().size();
  ASSERT_EQ(both->messages().size(), count + second->messages().size());
  for (std::size_t i = 0; i < both->messages().size(); ++i) {
    const Bag& part = i < count ? *first : *second;
    ASSERT_EQ(both->messages()[i].time, part.messages()[i < count ? i : i - count].time);
    ASSERT_EQ(bytesOf(*both, i), bytesOf(part, i < count ? i : i - count));
  }
}

// One file a format and compression, small ones.
TEST_F(BagData, CutAnywhereGivesWhatIsBeforeTheCut) {
  const test::ScratchFolder folder;
  for (const std::string file : {"odometry/tf.db3", "wire/chunks_lz4.mcap", "wire/chunks_zstd.mcap",
                                 "wire/example_bz2.bag", "odometry/tf.bag"}) {
    const std::string bytes = test::readFile(*data_ / file);
    const auto whole = contentsOf(*open(file));
    const fs::path path = folder / fs::path(file).filename();
    const bool isSqlite = file.ends_with(".db3");
    std::mt19937 random(1);
    std::vector<std::size_t> cuts{0, 1, 8, 13, 100, bytes.size() / 2, bytes.size() - 100, bytes.size() - 1};
    for (int i = 0; i < 16; ++i) cuts.push_back(random() % bytes.size());
    std::sort(cuts.begin(), cuts.end());
    std::size_t before = 0;
    for (const std::size_t cut : cuts) {
      SCOPED_TRACE(file + " " + std::to_string(cut));
      writeFile(path, bytes.substr(0, cut));
      std::unique_ptr<Bag> bag;
      const test::Caught caught = test::caught([&] { bag = openBag(path); });
      if (!bag) {
        EXPECT_THAT(caught.code, testing::AnyOf(ErrorCode::unsupportedFile, ErrorCode::malformedFile));
        continue;
      }
      std::size_t unreadable = 0;
      const test::BagContents found = contentsOf(*bag, &unreadable);
      EXPECT_TRUE(std::includes(whole.begin(), whole.end(), found.begin(), found.end()));
      EXPECT_TRUE(found.size() == whole.size() || !bag->warnings().empty());
      // Its tree may lie anywhere in an SQLite file.
      EXPECT_TRUE(isSqlite || (unreadable == 0 && found.size() >= before));
      before = found.size();
    }
    EXPECT_GT(before, 0U);
  }
}

class McapCore : public testing::Test {
 protected:
  void SetUp() override {
    modules_ = test::findFetched("test-tools/node_modules");
    ESTANCIA_NEEDS(modules_, "the tests' npm packages are missing; run script/bootstrap");
  }
  std::string runs(const std::string& verb, const fs::path& path) const {
    const auto result = test::runProgram(
        "node", {std::string(ESTANCIA_SOURCE_DIR) + "/tests/ros/mcap_core.js", *modules_, verb, path});
    EXPECT_EQ(result.exitCode, 0) << verb << path << result.err;
    return result.out;
  }
  std::optional<fs::path> modules_;
};

std::string digestOf(const Bag& bag) {
  std::string all;
  for (std::size_t i = 0; i < bag.messages().size(); ++i) {
    const std::int64_t time = bag.messages()[i].time;
    all.append(reinterpret_cast<const char*>(&time), sizeof time);
    all += test::bytesOf(bag, i);
  }
  return sha256(all) + "\n";
}

TEST_F(McapCore, ReadsTheSameBytes) {
  const auto data = test::findData("robot_bags");
  ESTANCIA_NEEDS(data, "no robot_bags");
  for (const char* file : {"wire/all_types.mcap", "wire/chunks_none.mcap"})
    EXPECT_EQ(digestOf(*openBag(*data / file)), runs("digest", *data / file)) << file;
}

TEST_F(McapCore, FilesAreReadHoweverTheyAreWritten) {
  const test::ScratchFolder folder;
  runs("write", folder.path());
  const std::string digest = runs("digest", folder / "usual.mcap");
  std::size_t files = 0;
  for (const auto& entry : fs::directory_iterator(folder.path())) {
    SCOPED_TRACE(entry.path());
    ++files;
    const auto bag = openBag(entry.path());
    EXPECT_THAT(bag->warnings(), testing::IsEmpty());
    EXPECT_EQ(test::countsOf(*bag), (std::map<std::string, std::size_t>{{"/odom", 200}, {"/tf", 100}}));
    EXPECT_THAT(bag->topics()[1], testing::FieldsAre("/tf", "tf2_msgs/TFMessage", Encoding::cdr, "cdr", 100));
    EXPECT_EQ(digestOf(*bag), digest);
  }
  EXPECT_EQ(files, 7U);
}

}  // namespace
}  // namespace estancia::ros
