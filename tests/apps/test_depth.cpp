// Recordings with depth, as files: checked, tracked, mapped with their faults, named by shapes.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "apps/json_of.hpp"
#include "check/recorded_room.hpp"
#include "estancia/files/cloud_file.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "estancia/stats/trajectory_error.hpp"
#include "estancia/world_file/world_map.hpp"
#include "support/errors.hpp"
#include "support/images.hpp"
#include "support/model_support.hpp"
#include "support/shape_drive.hpp"
#include "support/support.hpp"
#include "support/written_drive.hpp"

namespace estancia::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::ElementsAre;
using testing::IsEmpty;

class CheckCommand : public testing::Test {
 protected:
  void SetUp() override {
    for (std::size_t i = 0; i < room_.size(); ++i) {
      cv::Mat millimeters;
      room_.depth(i).convertTo(millimeters, CV_16U, 1000);
      const std::string name = fmt::format("{:.6f}.png", *room_.frame(i).timestamp);
      writeFile(folder_ / ("rgb/" + name), encoded(".png", room_.image(i)));
      writeFile(folder_ / ("depth/" + name), encoded(".png", millimeters));
    }
    writeFile(folder_ / "intrinsics.txt", "140 140 79.5 59.5\n");
    writePoses([](const cv::Affine3d& t) { return t; });
  }

  void writePoses(const std::function<cv::Affine3d(cv::Affine3d)>& change) {
    std::vector<TrajectoryPoint> points;
    for (std::size_t i = 0; i < room_.size(); ++i)
      points.push_back({room_.frame(i).timestamp, poseOf(change(rigidOf(*room_.frame(i).pose)))});
    writeTrajectory(points, folder_ / "poses.txt");
  }

  CommandResult check(const std::vector<std::string>& more = {}) {
    return run({"check", folder_.path().string()}, more);
  }

  /// The names of what is not fine.
  static std::vector<std::string> faults(const CommandResult& result) {
    std::vector<std::string> names;
    const json report = json::parse(result.out);
    for (const json& finding : report["findings"])
      if (finding["severity"] != "fine") names.push_back(finding["name"]);
    EXPECT_EQ(report["problems"].get<std::size_t>() + report["warnings"].get<std::size_t>(), names.size());
    EXPECT_EQ(result.exitCode, report["problems"] > 0 ? 1 : 0) << result.out;
    return names;
  }

  const RecordedRoom room_{40};
  ScratchFolder folder_;
};

TEST_F(CheckCommand, IsContentWithASoundRecordingAndTellsOfInvertedPoses) {
  const auto result = check({"--json"});
  EXPECT_THAT(faults(result), IsEmpty());
  EXPECT_EQ(json::parse(result.out)["frames"], 40);
  writePoses([](const cv::Affine3d& t) { return t.inv(); });
  EXPECT_THAT(faults(check({"--json"})), ElementsAre("pose-inverted"));
}

TEST_F(CheckCommand, TakesOptionsOfDepthAndCamera) {
  EXPECT_THAT(faults(check({"--json", "--depth-scale", "200"})), ElementsAre("depth-scale"));
  writeFile(folder_ / "large.yaml",
            "image_width: 320\nimage_height: 240\nK: [280, 0, 159.5, 0, 280, 119.5, 0, 0, 1]\n");
  EXPECT_THAT(faults(check({"--json", "--intrinsics", folder_ / "large.yaml"})), IsEmpty());
  writeFile(folder_ / "large.txt", "280 280 159.5 119.5\n");
  EXPECT_THAT(faults(check({"--json", "--intrinsics", folder_ / "large.txt"})), ElementsAre("camera-center"));
}

TEST_F(CheckCommand, RefusesWhatItCannotCheck) {
  writeFile(folder_ / "words.csv", "image,cat\na.png,1\n");
  EXPECT_THAT(run({"check", folder_ / "words.csv"}), FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT(run({"check", folder_ / "nowhere"}), FailsWith(ErrorCode::fileNotFound));
  EXPECT_THAT(check({"--depth-scale", "-1"}), FailsWith(ErrorCode::invalidOption));
  EXPECT_THAT(check({"--max-frames", "0"}), FailsWith(ErrorCode::invalidOption));
  EXPECT_THAT(check({"--intrinsics", folder_ / "nowhere.txt"}), FailsWith(ErrorCode::fileNotFound));
}

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

  CommandResult odometry(const std::vector<std::string>& more = {}) {
    return run({"odometry", "estimate", room_.string(), "-o", file_, "--no-loops", "--overwrite"}, more);
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
  EXPECT_EQ(jsonOf(odometry({"--intrinsics", camera, "--odom", wheels, "--json"}))["placed"], 2);
  writeFile(wheels, "0 nan nan nan 0 0 0 1\n1 nan nan nan 0 0 0 1\n");
  EXPECT_EQ(odometry({"--intrinsics", camera, "--odom", wheels}).exitCode, 2);
  writeFile(wheels, "these are no poses\n");
  EXPECT_EQ(odometry({"--intrinsics", camera, "--odom", wheels}).exitCode, 2);
}

/// The first frames of a rendered drive, without its poses.
class UnposedDrive : public testing::Test {
 protected:
  void SetUp() override {
    data_ = findData("home_a");
    ESTANCIA_NEEDS(data_, "the rendered home is not here");
    writeSmallModel(scratch_ / "model");
    fs::create_directories(drive_);
    fs::create_symlink(*data_ / "slow/camera-intrinsics.txt", drive_ / "camera-intrinsics.txt");
    for (const char* folder : {"rgb", "depth"}) fs::create_directories(drive_ / folder);
  }
  void showFramesUpTo(int end) {
    for (int i = 0; i < end; ++i)
      for (const auto& [folder, ending] : {std::pair("rgb", "jpg"), std::pair("depth", "png")}) {
        const std::string name = fmt::format("{}/{:06}.{}", folder, i, ending);
        ASSERT_TRUE(fs::exists(*data_ / "slow" / name)) << name;
        if (!fs::exists(drive_ / name)) fs::create_symlink(*data_ / "slow" / name, drive_ / name);
      }
  }
  CommandResult map(const std::string& file, const std::vector<std::string>& more = {}) const {
    return run({"map", drive_, "-o", scratch_ / file, "--model", scratch_ / "model", "--json"}, more);
  }

  const WithoutWordNet names_;  // which would be read by each command
  ScratchFolder scratch_;
  const fs::path drive_ = scratch_ / "drive";
  std::optional<fs::path> data_;
};

TEST_F(UnposedDrive, IsTrackedInThePassThatMapsItAndGoesOnAsIfItHadNotStopped) {
  for (const int end : {1, 13, 60}) {
    showFramesUpTo(end);
    const auto part = end == 1 ? map("broken.estancia") : map("broken.estancia", {"--continue"});
    ASSERT_EQ(part.exitCode, 0) << part.err;
  }
  const json odometry = jsonOf(map("whole.estancia"))["odometry"];
  EXPECT_EQ(odometry["placed"], 60);
  EXPECT_GT(odometry["keyframes"], 2);
  EXPECT_FALSE(odometry.contains("lost"));
  for (const char* format : {"json", "rooms", "spark-dsg"})
    EXPECT_EQ(run({"export", scratch_ / "broken.estancia", "--format", format}).out,
              run({"export", scratch_ / "whole.estancia", "--format", format}).out)
        << format;
  const WorldMap world = readWorld(scratch_ / "whole.estancia");
  EXPECT_FALSE(world.areas.empty());
  EXPECT_FALSE(world.objects.empty());
  const auto truth = openSequence(*data_ / "slow");
  std::vector<Pose> found, true_;
  for (std::size_t i = 0; i < world.places.frames.size(); ++i) {
    found.push_back(world.places.frames[i].pose.value());
    true_.push_back(truth->frame(i).pose.value());
  }
  EXPECT_LT(absoluteTrajectoryError(found, true_).rmse, 0.01);
}

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
  CommandResult map(const std::vector<std::string>& more = {}) const {
    return run({"map", drive_, "-o", scratch_ / "map.estancia", "--model", scratch_ / "model"}, more);
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
  const json faults = jsonOf(map({"--json"}))["faults"];
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

class MapNames : public testing::Test {
 protected:
  void SetUp() override {
    writeSmallModel(scratch_ / "model");
    writeDrive(ShapeDrive(desk), drive_);
  }
  CommandResult map(const std::vector<std::string>& more = {}) const {
    return run({"map", drive_, "-o", map_, "--model", scratch_ / "model"}, more);
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

  const std::string millimeters = "desk=" + (scratch_ / "millimeters.ply").string();
  writeCloud(surfaceOf(desk, 1000), scratch_ / "millimeters.ply");
  EXPECT_THAT(map({"--object", millimeters, "--continue"}), FailsWith(ErrorCode::invalidInput));
  EXPECT_EQ(
      json::parse(
          map({"--object", millimeters, "--object-unit", "mm", "--continue", "--json"}).out)["recognized"],
      (json{{"desk", 1}}));
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
