// The programs of examples/ that show the API's four tasks, run as a user runs them.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "support/color_model.hpp"
#include "support/support.hpp"
#include "support/table_scene.hpp"

namespace estancia::test {
namespace {

namespace fs = std::filesystem;

std::string example(const std::string& name) {
  return fs::path(ESTANCIA_EXAMPLES) / name;
}

/// The first word of each line, with how many lines begin with it.
std::map<std::string, int> linesBy(const std::string& text) {
  std::map<std::string, int> counts;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) ++counts[line.substr(0, line.find(' '))];
  return counts;
}

class Examples : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(scratch_ / "home/models");
    writeColorModel(scratch_ / "home/models/inception-v3");  // stands for the default network
    writeColorModel(scratch_ / "home/models/small");         // equals the first by its own name
    setenv("ESTANCIA_HOME", (scratch_ / "home").c_str(), 1);
    for (int i = 0; i < 24; ++i) {
      const bool isRed = i / 6 % 2 == 0;
      const fs::path folder = scratch_ / "images" / (isRed ? "red" : "blue");
      fs::create_directories(folder);
      const cv::Mat image(48, 64, CV_8UC3, isRed ? cv::Scalar(0, 0, 200 + i) : cv::Scalar(200 + i, 0, 0));
      cv::imwrite((folder / (std::to_string(i) + ".png")).string(), image);
      const std::string number = (i < 10 ? "0" : "") + std::to_string(i);
      cv::imwrite((scratch_ / ("camera" + number + ".png")).string(), image);
    }
  }
  void TearDown() override { unsetenv("ESTANCIA_HOME"); }

  ScratchFolder scratch_;
};

TEST_F(Examples, MapACameraAndAskTheMap) {
  const std::string map = scratch_ / "home.estancia";
  const CommandResult live = runProgram(example("02_map_live"), {map, scratch_ / "camera%02d.png", "word 0"});
  ASSERT_EQ(live.exitCode, 0) << live.err;
  EXPECT_GE(linesBy(live.out)["place"], 1) << live.out;

  const CommandResult later = runProgram(example("09_ask_a_map"), {map, "word 0"});
  ASSERT_EQ(later.exitCode, 0) << later.err;
  auto lines = linesBy(later.out);
  EXPECT_EQ(lines["place"], linesBy(live.out)["place"]);
  EXPECT_GE(lines["->"], 1) << later.out;
  EXPECT_EQ(later.out.substr(0, live.out.size()), live.out);  // the file holds what the session knew
}

TEST_F(Examples, MapLive) {
  const std::string map = scratch_ / "live.estancia";
  const CommandResult live = runProgram(example("11_live"), {scratch_ / "images/red", map});
  ASSERT_EQ(live.exitCode, 0) << live.err;
  auto lines = linesBy(live.out);
  EXPECT_EQ(lines["map"], 1) << live.out;
  EXPECT_EQ(lines["12.png:"], 1) << live.out;
}

TEST_F(Examples, AskForAThingAndTheWayToIt) {
  std::vector<double> around;
  for (int degrees = 0; degrees < 360; degrees += 5) around.push_back(degrees);
  TableSequence({ballAt(-0.15, 0.1, 0.08, red), boxAt(0.2, -0.1, {0.08, 0.06, 0.1}, blue)}, around)
      .writeTo(scratch_ / "drive");
  const CommandResult asked =
      runProgram(example("12_ask_for_a_mug"), {scratch_ / "drive", scratch_ / "table.estancia", "word 0"});
  ASSERT_EQ(asked.exitCode, 0) << asked.err;
  auto lines = linesBy(asked.out);
  EXPECT_EQ(lines["object"], 1) << asked.out << "the ball is red, the box is not";
  EXPECT_GE(lines["->"], 1) << asked.out;
}

TEST_F(Examples, NameTheRoomOfAnImage) {
  const std::string classifier = scratch_ / "rooms.classifier";
  const CommandResult trained =
      run({"classify", "train", scratch_ / "images", "-o", classifier, "--descriptor", "inception-v3",
           "--classifier", "knn", "--type", "classes"});
  ASSERT_EQ(trained.exitCode, 0) << trained.err;
  const CommandResult named =
      runProgram(example("06_name_a_room"), {classifier, scratch_ / "images/red/0.png"});
  ASSERT_EQ(named.exitCode, 0) << named.err;
  EXPECT_EQ(named.out.substr(0, 4), "red ") << named.out;
}

TEST_F(Examples, FindAnObjectInACloud) {
  const auto data = findData("shot_kinect");
  ESTANCIA_NEEDS(data, "shot_kinect is not unpacked");
  const CommandResult found = runProgram(example("07_find_objects"),
                                         {*data / "meshes/mario000_0.ply", *data / "scenes/scene001.pcd"});
  ASSERT_EQ(found.exitCode, 0) << found.err;
  EXPECT_EQ(linesBy(found.out)["object"], 1) << found.out;
}

}  // namespace
}  // namespace estancia::test
