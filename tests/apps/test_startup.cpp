// What the command loads when it starts, and what it does without its modules.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "support/errors.hpp"
#include "support/sample_world.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

namespace fs = std::filesystem;

TEST(Startup, LoadsNeitherImageCodecsNorVideoInput) {
  const auto loaded = runProgram("/usr/bin/env", {"LD_TRACE_LOADED_OBJECTS=1", ESTANCIA_COMMAND});
  EXPECT_NE(loaded.out.find("libopencv_core"), std::string::npos);
  for (const char* large :
       {"libopencv_imgcodecs", "libopencv_videoio", "libgdal", "libavcodec", "libmpi", "libcholmod"})
    EXPECT_EQ(loaded.out.find(large), std::string::npos) << large;
}

/// The command alone, far from its modules.
class LoneCommand : public testing::Test {
 protected:
  void SetUp() override { fs::copy_file(ESTANCIA_COMMAND, command_); }
  const ScratchFolder scratch_;
  const std::string command_ = scratch_ / "estancia";
};

TEST_F(LoneCommand, AsksAMapWithAFloorPlan) {
  writeWorld(sampleWorld(), scratch_ / "home.estancia");
  const auto asked = runProgram(command_, {"ask", scratch_ / "home.estancia", "mug"});
  EXPECT_EQ(asked.exitCode, 0) << asked.err;
}

TEST_F(LoneCommand, SaysWhichModuleItNeedsForImagesAndForVideos) {
  fs::create_directory(scratch_ / "drive");
  for (const char* name : {"drive/1.png", "drive/2.png"})
    cv::imwrite(scratch_ / name, cv::Mat(48, 64, CV_8UC3, cv::Scalar(9, 99, 200)));
  EXPECT_THAT(runProgram(command_, {"check", scratch_ / "drive"}), FailsWith(ErrorCode::missingDependency));
  writeFile(scratch_ / "drive.mp4", std::string("\0\1\2\3", 4));
  EXPECT_THAT(runProgram(command_, {"check", scratch_ / "drive.mp4"}),
              FailsWith(ErrorCode::missingDependency));
}

TEST_F(LoneCommand, SaysBeforeTheFirstFrameWhatItNeedsForMotion) {
  fs::copy_file(ESTANCIA_IMAGES_FILE, scratch_ / "libestancia_images.so");
  for (const char* folder : {"drive/rgb", "drive/depth"}) fs::create_directories(scratch_ / folder);
  cv::imwrite(scratch_ / "drive/rgb/1.png", cv::Mat(48, 64, CV_8UC3, cv::Scalar(9, 99, 200)));
  cv::imwrite(scratch_ / "drive/depth/1.png", cv::Mat(48, 64, CV_16U, cv::Scalar(1000)));
  writeFile(scratch_ / "drive/intrinsics.txt", "60 60 32 24\n");
  const auto tracked = runProgram(
      command_, {"odometry", "estimate", scratch_ / "drive", "-o", scratch_ / "traj.txt", "--no-loops"});
  EXPECT_THAT(tracked, FailsWith(ErrorCode::missingDependency));
  EXPECT_FALSE(fs::exists(scratch_ / "traj.txt"));
}

}  // namespace
}  // namespace estancia::test
