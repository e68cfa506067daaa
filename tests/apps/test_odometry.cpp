// `estancia odometry estimate` as a user runs it.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

using nlohmann::json;

class OdometryCommand : public testing::Test {
 protected:
  /// Two images of a wall, one meter away by millimeters; without a camera file.
  void SetUp() override {
    cv::Mat image(120, 160, CV_8UC3);
    cv::theRNG().state = 7;
    cv::randu(image, 0, 255);
    const cv::Mat depth(120, 160, CV_16U, cv::Scalar(1000));
    for (const std::string folder : {"rgb", "depth"}) std::filesystem::create_directories(room_ / folder);
    for (const std::string name : {"0.png", "1.png"}) {
      cv::imwrite((room_ / "rgb" / name).string(), image);
      cv::imwrite((room_ / "depth" / name).string(), depth);
    }
    writeFile(scratch_ / "camera.txt", "140 140 79.5 59.5\n");
  }

  CommandResult odometry(std::vector<std::string> more = {}) {
    more.insert(more.begin(),
                {"odometry", "estimate", room_.string(), "-o", file_, "--no-loops", "--overwrite"});
    return run(more);
  }

  ScratchFolder scratch_;
  const std::filesystem::path room_ = std::filesystem::path(scratch_ / "room");
  const std::string file_ = scratch_ / "traj.txt";
};

TEST_F(OdometryCommand, FollowsACameraThatStands) {
  const auto result = odometry({"--intrinsics", scratch_ / "camera.txt", "--json"});
  ASSERT_EQ(result.exitCode, 0) << result.err;
  const json found = json::parse(result.out);
  EXPECT_EQ(found["frames"], 2);
  EXPECT_EQ(found["placed"], 2);
  EXPECT_FALSE(found.contains("error")) << "there are no true poses";
  EXPECT_EQ(result.err.find("Open3D"), std::string::npos);
}

TEST_F(OdometryCommand, RefusesWhatItCannotTrack) {
  const std::string camera = scratch_ / "camera.txt";
  EXPECT_THAT(odometry(), FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT(run({"odometry", "estimate", room_ / "rgb", "-o", file_, "--intrinsics", camera}),
              FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT(odometry({"--intrinsics", camera, "--depth-scale", "10"}),
              FailsWith(ErrorCode::insufficientData))
      << "a wall 100 m away is beyond --max-depth";
  EXPECT_FALSE(std::filesystem::exists(file_)) << "nothing half done";
  writeFile(file_, "mine");
  EXPECT_THAT(run({"odometry", "estimate", room_.string(), "-o", file_, "--no-loops"}),
              FailsWith(ErrorCode::fileExists));
  EXPECT_EQ(readFile(file_), "mine");
}

TEST_F(OdometryCommand, TakesTheMotionOfWheels) {
  const std::string wheels = scratch_ / "wheels.txt", camera = scratch_ / "camera.txt";
  writeFile(wheels, "0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n");
  const auto result = odometry({"--intrinsics", camera, "--odom", wheels, "--json"});
  ASSERT_EQ(result.exitCode, 0) << result.err;
  EXPECT_EQ(json::parse(result.out)["placed"], 2);
  writeFile(wheels, "0 nan nan nan 0 0 0 1\n1 nan nan nan 0 0 0 1\n");
  EXPECT_EQ(odometry({"--intrinsics", camera, "--odom", wheels}).exitCode, 2);
  writeFile(wheels, "these are no poses\n");
  EXPECT_EQ(odometry({"--intrinsics", camera, "--odom", wheels}).exitCode, 2);
}

}  // namespace
}  // namespace estancia::test
