// `estancia map` of drives whose depth or poses are wrong, or that go on otherwise than they began.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "support/errors.hpp"
#include "support/model_support.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// A camera that moves along x before a wall.
class FaultyDrive : public testing::Test {
 protected:
  void SetUp() override {
    writeSmallModel(scratch_ / "model");
    for (const char* folder : {"rgb", "depth"}) fs::create_directories(drive_ / folder);
    setCamera(100);
  }
  void setCamera(int focalLength) const {
    writeFile(drive_ / "camera-intrinsics.txt", fmt::format("{0} 0 79.5\n0 {0} 59.5\n0 0 1\n", focalLength));
  }
  /// Frames up to `end`, which all show one depth; one of them is 100 m away by its pose.
  void show(int end, int depth, int jump = -1) const {
    std::string poses;
    for (int i = 0; i < end; ++i) {
      cv::imwrite(drive_ / fmt::format("rgb/{:03}.png", i), cv::Mat(120, 160, CV_8UC3, cv::Scalar(9, i, 99)));
      cv::imwrite(drive_ / fmt::format("depth/{:03}.png", i), cv::Mat(120, 160, CV_16U, cv::Scalar(depth)));
      poses += fmt::format("{} {} 0 1 -0.5 0.5 -0.5 0.5\n", 0.1 * i, 0.1 * i + (i == jump ? 100 : 0));
    }
    writeFile(drive_ / "poses.txt", poses);
  }
  CommandResult map(std::vector<std::string> more = {}) const {
    more.insert(more.begin(),
                {"map", drive_, "-o", scratch_ / "map.estancia", "--model", scratch_ / "model"});
    return run(more);
  }

  const WithoutWordNet names_;  // which would be read by each command
  ScratchFolder scratch_;
  const fs::path drive_ = scratch_ / "drive";
};

/// A folder of a hundred thousand must not fill the terminal.
TEST_F(FaultyDrive, NamesTheFirstBrokenImagesAndCountsTheOthers) {
  show(60, 2000);
  for (int i = 1; i < 60; ++i)
    writeFile(drive_ / fmt::format("{}/{:03}.png", i < 30 ? "rgb" : "depth", i), "broken");
  const auto mapped = map();
  EXPECT_EQ(mapped.exitCode, 0) << mapped.err;
  EXPECT_LT(std::ranges::count(mapped.err, '\n'), 60) << mapped.err;
}

TEST_F(FaultyDrive, SaysWherePosesJump) {
  show(12, 2000, 7);
  const auto mapped = map({"--json"});
  EXPECT_EQ(mapped.exitCode, 0) << mapped.err;
  const json faults = json::parse(mapped.out)["faults"];
  EXPECT_EQ(faults["pose_jumps"], 2);
  EXPECT_EQ(faults["jumps"][1]["to"], "008.png");
}

TEST_F(FaultyDrive, GoesOnOnlyAsItBegan) {
  show(4, 2000);
  ASSERT_EQ(map({"--set", "world.areas.cell=0.1"}).exitCode, 0);
  show(6, 2000);
  EXPECT_THAT(map({"--continue", "--set", "world.areas.cell=0.2"}), FailsWith(ErrorCode::mismatch));
  EXPECT_THAT(map({"--continue", "--depth-scale", "5000"}), FailsWith(ErrorCode::mismatch));
  setCamera(120);
  EXPECT_THAT(map({"--continue"}), FailsWith(ErrorCode::mismatch));
  setCamera(100);
  EXPECT_EQ(map({"--continue", "--threads", "1"}).exitCode, 0) << "it keeps its options";
}

}  // namespace
}  // namespace estancia::test
