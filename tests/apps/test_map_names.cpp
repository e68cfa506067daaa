// `estancia map` with known objects and an object model.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "estancia/files/cloud_file.hpp"
#include "support/errors.hpp"
#include "support/model_support.hpp"
#include "support/shape_drive.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class MapNames : public testing::Test {
 protected:
  void SetUp() override {
    writeSmallModel(scratch_ / "model");
    for (const char* folder : {"rgb", "depth"}) fs::create_directories(drive_ / folder);
    const ShapeDrive shown(desk);
    const CameraIntrinsics& camera = *shown.intrinsics();
    writeFile(drive_ / "camera-intrinsics.txt",
              fmt::format("{} 0 {}\n0 {} {}\n0 0 1\n", camera.fx, camera.cx, camera.fy, camera.cy));
    std::string poses;
    for (std::size_t i = 0; i < shown.size(); ++i) {
      cv::Mat millimeters;
      shown.depth(i).convertTo(millimeters, CV_16U, 1000);
      cv::imwrite(drive_ / fmt::format("rgb/{:03}.png", i), shown.image(i));
      cv::imwrite(drive_ / fmt::format("depth/{:03}.png", i), millimeters);
      const Pose& p = *shown.frame(i).pose;
      poses += fmt::format("{} {} {} {} {} {} {} {}\n", i, p.x, p.y, p.z, p.qx, p.qy, p.qz, p.qw);
    }
    writeFile(drive_ / "poses.txt", poses);
  }
  CommandResult map(std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"map", drive_, "-o", map_, "--model", scratch_ / "model"});
    return run(more);
  }

  ScratchFolder scratch_;
  const fs::path drive_ = scratch_ / "drive";
  const std::string map_ = scratch_ / "map.estancia";
};

TEST_F(MapNames, SaysWhichObjectsAreRecognized) {
  const std::string cloud = "desk=" + (scratch_ / "cloud.ply").string();
  writeCloud(surfaceOf(desk), scratch_ / "cloud.ply");
  const auto mapped = map({"--object", cloud});
  EXPECT_EQ(mapped.exitCode, 0) << mapped.err;
  EXPECT_EQ(run({"ask", map_, "desk"}).exitCode, 0);
  EXPECT_EQ(json::parse(map({"--object", cloud, "--continue", "--json"}).out)["recognized"],
            (json{{"desk", 1}}));
  EXPECT_FALSE(json::parse(map({"--overwrite", "--json"}).out).contains("recognized"));
}

TEST_F(MapNames, SaysWhichClassesObjectsAreOfByShape) {
  const std::string model = scratch_ / "shapes.objects";
  writeObjectModel(modelOfShapes(), model);
  const auto mapped = map({"--object-model", model});
  EXPECT_EQ(mapped.exitCode, 0) << mapped.err;
  EXPECT_EQ(json::parse(map({"--object-model", model, "--continue", "--json"}).out)["shapes"],
            (json{{"desk", 1}}));
  EXPECT_EQ(map({"--continue"}).exitCode, 0);
  EXPECT_EQ(run({"ask", map_, "desk"}).exitCode, 0);
}

TEST_F(MapNames, RefusesWhatIsNoModelBeforeItMaps) {
  EXPECT_THAT(map({"--object-model", scratch_ / "missing.objects"}), FailsWith(ErrorCode::fileNotFound));
  writeFile(scratch_ / "text.objects", "no model\n");
  EXPECT_THAT(map({"--object-model", scratch_ / "text.objects"}), FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT(map({"--object", scratch_ / "missing.ply"}), FailsWith(ErrorCode::fileNotFound));
  EXPECT_FALSE(fs::exists(map_));
}

}  // namespace
}  // namespace estancia::test
