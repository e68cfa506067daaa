// MCAP files, compared with another reader and writer: npm's @mcap/core.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estancia/core/digest.hpp"
#include "ros/bag_contents.hpp"
#include "support/support.hpp"

namespace estancia::ros {
namespace {

namespace fs = std::filesystem;

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
  for (const char* file : {"wire/all_types.mcap", "wire/chunks_none.mcap", "wire/chunks_lz4.mcap",
                           "wire/chunks_zstd.mcap", "wire/split_0.mcap"})
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
    EXPECT_EQ(bag->topics()[1].type, "tf2_msgs/TFMessage");
    EXPECT_EQ(bag->topics()[1].encoding, Encoding::cdr);
    EXPECT_EQ(digestOf(*bag), digest);
  }
  EXPECT_EQ(files, 7U);
}

}  // namespace
}  // namespace estancia::ros
