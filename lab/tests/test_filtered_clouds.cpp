// SPDX-License-Identifier: Apache-2.0
#include "recognition/filtered_clouds.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estancia/core/error.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia::experiments {
namespace {

using test::FailsWith;
using test::readFile;
using test::ScratchFolder;
using test::writeFile;
namespace fs = std::filesystem;

PointCloud sheet(std::size_t side) {
  PointCloud cloud;
  for (std::size_t i = 0; i < side * side; ++i)
    cloud.points.emplace_back(0.01F * static_cast<float>(i % side), 0.01F * static_cast<float>(i / side),
                              1.0F);
  cloud.width = cloud.points.size();
  cloud.height = 1;
  return cloud;
}

class FilteredCloudsTest : public testing::Test {
 protected:
  FilteredClouds::Filtered get(const std::string& origin = "a", std::size_t points = 50,
                               std::uint64_t maxBytes = 1 << 20) {
    return FilteredClouds(folder, maxBytes).get(origin, filter("voxel", points), [&] {
      ++read;
      return sheet(20);
    });
  }
  static FilterOptions filter(const std::string& method, std::size_t points) {
    FilterOptions options;
    options.method = method;
    options.points = points;
    return options;
  }
  std::vector<fs::path> files() const {
    std::vector<fs::path> all;
    std::error_code none;
    for (const auto& entry : fs::directory_iterator(folder, none)) all.push_back(entry.path());
    return all;
  }

  ScratchFolder scratch;
  fs::path folder = scratch / "filtered";
  int read = 0;
};

TEST_F(FilteredCloudsTest, GivesTheSameWithoutFilteringAgain) {
  const auto first = get(), second = get();
  EXPECT_EQ(read, 1);
  EXPECT_FALSE(first.cloud.points.empty());
  EXPECT_LT(first.cloud.points.size(), 400U);
  EXPECT_EQ(second.cloud.points, first.cloud.points);
  EXPECT_EQ(second.cloud.normals, first.cloud.normals);
  EXPECT_EQ(second.cloud.width, first.cloud.points.size());
  EXPECT_EQ(second.cloud.height, 1U);
  EXPECT_EQ(second.seconds, first.seconds) << "what it took then";
}

TEST_F(FilteredCloudsTest, TellsOriginsAndFiltersApart) {
  const auto coarse = get("a", 20).cloud.points.size(), fine = get("a", 100).cloud.points.size();
  EXPECT_LT(coarse, fine);
  get("b", 100);
  EXPECT_EQ(read, 3);
  FilterOptions gng = filter("gng", 20), other = gng;
  other.gng.seed = 2;
  EXPECT_NE(FilteredClouds::describe(gng), FilteredClouds::describe(other));
}

TEST_F(FilteredCloudsTest, WithoutAFilterNothingIsKept) {
  const auto raw = FilteredClouds(folder, 1 << 20).get("a", filter("none", 5), [] { return sheet(3); });
  EXPECT_EQ(raw.cloud.points.size(), 9U);
  EXPECT_EQ(raw.seconds, 0);
  get("a", 50, 0);
  EXPECT_TRUE(files().empty());
}

TEST_F(FilteredCloudsTest, DamagedFilesAreMadeAgain) {
  const auto whole = get();
  ASSERT_EQ(files().size(), 1U);
  const fs::path file = files()[0];
  const std::string bytes = readFile(file);
  std::string flipped = bytes, other = bytes;
  flipped[bytes.size() - 3] = static_cast<char>(flipped[bytes.size() - 3] ^ 1);
  other.replace(0, 26, "ESTANCIA FILTERED CLOUD 3\n");
  for (const std::string& damaged :
       {std::string(), bytes.substr(0, 40), bytes.substr(0, bytes.size() - 1), flipped, other}) {
    writeFile(file, damaged);
    read = 0;
    EXPECT_EQ(get().cloud.points, whole.cloud.points);
    EXPECT_EQ(read, 1);
    EXPECT_EQ(readFile(file).size(), bytes.size());
  }
  fs::copy_file(file, scratch / "copy");
  get("b");
  for (const fs::path& one : files())
    fs::copy_file(scratch / "copy", one, fs::copy_options::overwrite_existing);
  read = 0;
  get("b");
  EXPECT_EQ(read, 1) << "a file of another origin under this one's name";
}

TEST_F(FilteredCloudsTest, TheOldestGoWhenThereIsNoRoom) {
  get("a");
  const auto bytes = fs::file_size(files()[0]);
  fs::last_write_time(files()[0], fs::file_time_type::clock::now() - std::chrono::hours(2));
  get("b", 50, 2 * bytes);
  EXPECT_EQ(files().size(), 2U);
  get("c", 50, 2 * bytes);
  EXPECT_EQ(files().size(), 2U);
  read = 0;
  get("b", 50, 2 * bytes);
  EXPECT_EQ(read, 0) << "a went";
}

TEST_F(FilteredCloudsTest, WhatCannotBeFilteredOrWrittenIsAnError) {
  FilteredClouds clouds(folder, 1 << 20);
  EXPECT_THROW(clouds.get("a", filter("median", 5), [] { return sheet(3); }), Error);
  writeFile(scratch / "file", "");
  EXPECT_THAT(
      [&] {
        FilteredClouds(scratch / "file/in", 1 << 20).get("a", filter("voxel", 5), [] { return sheet(9); });
      },
      FailsWith(ErrorCode::fileUnwritable));
}

}  // namespace
}  // namespace estancia::experiments
