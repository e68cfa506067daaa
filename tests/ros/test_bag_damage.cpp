// Bags that are cut off or damaged anywhere: what is whole is used, and nothing worse than an Error happens.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "ros/bag_contents.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia::ros {
namespace {

namespace fs = std::filesystem;
using test::contentsOf;

class DamagedBag : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    const auto data = test::findData("robot_bags");
    ESTANCIA_NEEDS(data, "no robot_bags");
    bytes_ = test::readFile(*data / GetParam());
    whole_ = contentsOf(*openBag(*data / GetParam()));
  }
  fs::path write(const std::string& bytes) {
    const fs::path path = folder_ / fs::path(GetParam()).filename().string();
    test::writeFile(path, bytes);
    return path;
  }
  bool isSqlite() const { return std::string(GetParam()).ends_with(".db3"); }

  test::ScratchFolder folder_;
  std::string bytes_;
  test::BagContents whole_;
};

TEST_P(DamagedBag, CutAnywhereGivesWhatIsBeforeTheCut) {
  std::mt19937 random(1);
  std::vector<std::size_t> cuts{0, 1, 8, 13, 100, bytes_.size() / 2, bytes_.size() - 100, bytes_.size() - 1};
  for (int i = 0; i < 16; ++i) cuts.push_back(random() % bytes_.size());
  std::sort(cuts.begin(), cuts.end());
  std::size_t before = 0;
  for (const std::size_t cut : cuts) {
    SCOPED_TRACE(cut);
    const fs::path path = write(bytes_.substr(0, cut));
    std::unique_ptr<Bag> bag;
    const test::Caught caught = test::caught([&] { bag = openBag(path); });
    if (!bag) {
      EXPECT_THAT(caught.code, testing::AnyOf(ErrorCode::unsupportedFile, ErrorCode::malformedFile));
      continue;
    }
    std::size_t unreadable = 0;
    const test::BagContents found = contentsOf(*bag, &unreadable);
    if (!isSqlite()) {
      EXPECT_EQ(unreadable, 0U);
    }
    EXPECT_TRUE(std::includes(whole_.begin(), whole_.end(), found.begin(), found.end()));
    if (found.size() < whole_.size()) {
      EXPECT_FALSE(bag->warnings().empty());
    }
    // Its tree may lie anywhere in an SQLite file.
    if (!isSqlite()) {
      EXPECT_GE(found.size(), before);
    }
    before = found.size();
  }
  EXPECT_GT(before, 0U);
}

// One file a format and compression, small ones.
INSTANTIATE_TEST_SUITE_P(RobotBags, DamagedBag,
                         testing::Values("odometry/tf.db3", "wire/chunks_lz4.mcap", "wire/chunks_zstd.mcap",
                                         "wire/example_bz2.bag", "odometry/tf.bag"),
                         [](const auto& file) {
                           std::string name = fs::path(file.param).filename().string();
                           std::replace_if(
                               name.begin(), name.end(), [](char c) { return c == '.' || c == '_'; }, '0');
                           return name;
                         });

}  // namespace
}  // namespace estancia::ros
