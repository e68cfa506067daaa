// Words on the floor: a camera turns in a room with a red, a green and a blue wall, and things stand at them.
// SPDX-License-Identifier: Apache-2.0
#include "places/word_positions.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgcodecs.hpp>

#include "color_drive.hpp"
#include "support/errors.hpp"
#include "support/floor_scene.hpp"

namespace estancia::experiments {
namespace {

using test::FailsWith;
using test::writeFile;

class WordPositions : public testing::Test {
 protected:
  /// The small model calls red "word 2", green "word 1", blue "word 3". A camera in the middle of a room of
  /// 4 × 4 m looks east (red), north (green), west (blue) and south (red), three times each.
  void SetUp() override {
    test::writeColorModel(scratch_, "sharp", "0.5");
    const std::array<cv::Scalar, 4> colors{{{20, 20, 230}, {20, 230, 20}, {230, 20, 20}, {20, 20, 230}}};
    std::string poses, rooms = "image,room\n", visible = "image,id,pixels,pixels_with_depth\n";
    for (int i = 0; i < 12; ++i) {
      const int side = i / 3;
      const Pose pose = test::lookingAt(2, 2, 1, std::numbers::pi / 2 * side + 0.1 * (i % 3 - 1), -0.1);
      const std::string name = fmt::format("{:06}", i);
      cv::Mat depth;
      test::boxDepth(pose, {0, 0, 4, 4}).convertTo(depth, CV_16U, 1000);
      for (const char* folder : {"rgb", "depth"})
        std::filesystem::create_directories(scratch_ / "home" / folder);
      cv::imwrite(scratch_ / ("home/depth/" + name + ".png"), depth);
      cv::imwrite(scratch_ / ("home/rgb/" + name + ".png"), cv::Mat(48, 64, CV_8UC3, colors[side]));
      poses += fmt::format("{} {} {} {} {} {} {} {}\n", i, pose.x, pose.y, pose.z, pose.qx, pose.qy, pose.qz,
                           pose.qw);
      rooms += name + ".png,room\n";
      if (side < 3) visible += fmt::format("{}.png,{},600,600\n", name, 10 + side);
    }
    writeFile(scratch_ / "home/poses.txt", poses);
    writeFile(scratch_ / "home/rooms.csv", rooms);
    writeFile(scratch_ / "home/visible.csv", visible);
    writeFile(scratch_ / "home/camera-intrinsics.txt", "52.5 0 31.5\n0 52.5 23.5\n0 0 1\n");
    writeFile(scratch_ / "home/home.json",
              R"({"rooms": [{"name": "room", "polygon": [[0, 0], [4, 0], [4, 4], [0, 4]]}]})");
    // sofa east, plant north, stove west: nothing is south
    writeFile(scratch_ / "home/instances.csv",
              "id,category,model,model_name,room,x,y,z,size_x,size_y,size_z,yaw_degrees\n"
              "10,sofa,m,n,room,3.8,2,0.5,1,0.4,1,90\n11,plant,m,n,room,2,3.8,0.5,1,0.4,1,0\n"
              "12,stove,m,n,room,0.2,2,0.5,1,0.4,1,90\n");
  }

  /// All images are taken at one spot, so words are known by their direction, hardly by their distance.
  Findings run(const std::string& words) {
    writeFile(scratch_ / "words.toml", "type = \"word-map\"\nreach = 1.5\n[words]\n" + words +
                                           "[[drive]]\nname = \"turn\"\npath = \"home\"\n");
    return runExperiment({scratch_ / "words.toml"},
                         {scratch_ / "out", {scratch_ / "sharp"}, {"", 1}, nullptr}, progress_);
  }

  test::ScratchFolder scratch_;
  Progress progress_;
};

/// Row of the first table: categories, found, share; a row each kind of evidence.
std::vector<double> row(const Findings& findings, std::size_t evidence) {
  std::vector<double> values;
  for (const auto& value : std::get<ResultTable>(findings.sections.at(0)).rows.at(evidence).values)
    values.push_back(value.value());
  return values;
}

TEST_F(WordPositions, AreWhereTheThingsAre) {
  const Findings found = run("plant = [\"word 1\"]\nstove = [\"word 3\"]\n");
  EXPECT_THAT(row(found, 0), testing::ElementsAre(2, 2, 1));
  EXPECT_THAT(row(found, 2), testing::ElementsAre(2, 2, 1));
}

TEST_F(WordPositions, WrongWordsAreElsewhereButTrueOnesAreThere) {
  const Findings found =
      run("plant = [\"word 2\", \"word 3\"]\nstove = [\"word 7\"]\nghost = [\"word 1\"]\n");
  EXPECT_THAT(row(found, 0), testing::ElementsAre(2, 0, 0))
      << "nobody sees a ghost, and no word is the stove's";
  EXPECT_THAT(row(found, 2), testing::ElementsAre(2, 2, 1));
  const auto& distances = std::get<ResultTable>(found.sections.at(1));
  ASSERT_EQ(distances.rows.at(0).name, "plant");
  EXPECT_GT(distances.rows[0].values[0].value(), 1.5);
  EXPECT_LE(distances.rows[0].values[2].value(), 1.5);
}

TEST_F(WordPositions, NeedTheTruthAndThings) {
  EXPECT_THAT(test::caught([&] { run("ghost = [\"word 1\"]\n"); }), FailsWith(ErrorCode::insufficientData));
  EXPECT_THAT(test::caught([&] { run("plant = []\n"); }),
              FailsWith(ErrorCode::malformedFile, "words.toml:4"));
  std::filesystem::remove(scratch_ / "home/instances.csv");
  EXPECT_THAT(test::caught([&] { run("plant = [\"word 1\"]\n"); }),
              FailsWith(ErrorCode::fileUnreadable, "instances.csv"));
}

}  // namespace
}  // namespace estancia::experiments
