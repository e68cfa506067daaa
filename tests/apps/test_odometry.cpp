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

TEST_F(OdometryCommand, NamesWhatIsMissing) {
  EXPECT_THAT(odometry(), FailsWith(ErrorCode::invalidInput, "--intrinsics"));
  const auto flat =
      run({"odometry", "estimate", room_ / "rgb", "-o", file_, "--intrinsics", scratch_ / "camera.txt"});
  EXPECT_THAT(flat, FailsWith(ErrorCode::invalidInput));
  EXPECT_FALSE(std::filesystem::exists(file_)) << "nothing half done";
}

TEST_F(OdometryCommand, TakesTheScaleOfDepth) {
  const auto far = odometry({"--intrinsics", scratch_ / "camera.txt", "--depth-scale", "10"});
  EXPECT_THAT(far, FailsWith(ErrorCode::insufficientData, "--depth-scale"))
      << "a wall 100 m away is beyond --max-depth";
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

TEST_F(OdometryCommand, ReplacesNothingUntold) {
  writeFile(file_, "mine");
  const auto result = run({"odometry", "estimate", room_.string(), "-o", file_, "--no-loops"});
  EXPECT_THAT(result, FailsWith(ErrorCode::fileExists, "--overwrite"));
  EXPECT_EQ(readFile(file_), "mine");
}

TEST(Kitchen, IsTrackedWithLoopsAndItsZonesArePlaced) {
  const auto data = findData("sevenscenes_redkitchen");
  ESTANCIA_NEEDS(data && findFetched("models/inception-v3/inception-v3.onnx"),
                 "the kitchen sequence or the default network is not here");
  const ScratchFolder scratch;
  const std::string file = scratch / "traj.txt";
  const auto result = run({"odometry", "estimate", *data, "-o", file, "--json"});
  ASSERT_EQ(result.exitCode, 0) << result.err;
  const json found = json::parse(result.out);
  EXPECT_EQ(found["placed"], 200);
  EXPECT_GE(found["loops"], 5);
  EXPECT_LE(found["error"]["rmse"], 0.08);
  const auto zones = run({"zones", "find", *data, "--poses", file, "--model", "inception-v3", "-o",
                          scratch / "kitchen.zones", "--json"});
  ASSERT_EQ(zones.exitCode, 0) << zones.err;
  EXPECT_TRUE(json::parse(zones.out)["zones"][0]["position"].is_array());
}

}  // namespace
}  // namespace estancia::test
