// `estancia areas find` refuses what it cannot use, and reports where words are.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <numbers>
#include <opencv2/imgcodecs.hpp>

#include "estancia/sequences/descriptor_sequence.hpp"
#include "estancia/world_file/world_map.hpp"
#include "support/errors.hpp"
#include "support/floor_scene.hpp"
#include "support/model_support.hpp"
#include "support/support.hpp"
#include "support/synthetic.hpp"

namespace estancia::test {
namespace {

class AreasCommand : public testing::Test {
 protected:
  void SetUp() override {
    SyntheticPlaces places(2, 3);
    DescriptorSequence recording{Vocabulary({"stove", "bed", "tub"}), "test", {}, DescriptorMatrix(3)};
    for (std::size_t i = 0; i < 6; ++i) {
      Frame frame;
      frame.name = std::to_string(i);
      recording.frames.push_back(frame);
      recording.descriptors.append(places.image(i / 3));
    }
    writeDescriptors(recording, words_);
  }

  const WithoutWordNet names_;  // which would be read by each command
  ScratchFolder scratch_;
  const std::string words_ = scratch_ / "home.labels", file_ = scratch_ / "home.zones";
};

TEST_F(AreasCommand, ChecksDepthOptionsAndOutputsFirst) {
  EXPECT_THAT(run({"areas", "find", words_, "-o", file_}), FailsWith(ErrorCode::insufficientData));
  EXPECT_FALSE(std::filesystem::exists(file_));
  EXPECT_THAT(run({"areas", "find", words_, "-o", file_, "--set", "areas.cell=0"}),
              FailsWith(ErrorCode::invalidOption));
  writeFile(file_, "not ours");
  EXPECT_THAT(run({"areas", "find", words_, "-o", file_}), FailsWith(ErrorCode::fileExists));
  EXPECT_EQ(readFile(file_), "not ours");
}

TEST_F(AreasCommand, ZonesOfAnotherDriveSayNothingOfAMap) {
  const std::string map = scratch_ / "home.estancia";
  ASSERT_EQ(run({"map", words_, "-o", map}).exitCode, 0);
  ASSERT_EQ(run({"zones", "find", words_, "-o", file_, "--count", "2"}).exitCode, 0);
  const auto found = run({"localize", map, words_, "--zones", file_, "--json"});
  EXPECT_EQ(found.exitCode, 0) << found.err;
  const std::string line = found.out.substr(0, found.out.find('\n'));
  EXPECT_TRUE(nlohmann::json::parse(line).contains("belief_zone"));
  std::string text = readFile(file_);
  for (std::size_t i = 0; i < 6; ++i) {
    const std::string from = "\"name\":\"" + std::to_string(i) + "\"",
                      to = "\"name\":\"x" + std::to_string(i) + "\"";
    if (const auto at = text.find(from); at != std::string::npos) text.replace(at, from.size(), to);
  }
  writeFile(file_, text);
  EXPECT_THAT(run({"localize", map, words_, "--zones", file_}), FailsWith(ErrorCode::mismatch));
}

/// A turn in the middle of a room, whose walls are all green: "word 1" of the small model.
void writeTurn(const std::string& home) {
  std::string poses;
  for (int i = 0; i < 12; ++i) {
    const Pose pose = lookingAt(2, 2, 1, i * std::numbers::pi / 6, -0.1);
    cv::Mat depth;
    boxDepth(pose, {0, 0, 4, 4}).convertTo(depth, CV_16U, 1000);
    for (const char* folder : {"/rgb", "/depth"}) std::filesystem::create_directories(home + folder);
    const std::string name = "/" + std::to_string(10 + i) + ".png";
    cv::imwrite(home + "/depth" + name, depth);
    cv::imwrite(home + "/rgb" + name, cv::Mat(48, 64, CV_8UC3, cv::Scalar(0, 255, 0)));
    poses += fmt::format("{} {} {} {} {} {} {} {}\n", i, pose.x, pose.y, pose.z, pose.qx, pose.qy, pose.qz,
                         pose.qw);
  }
  writeFile(home + "/poses.txt", poses);
  writeFile(home + "/camera-intrinsics.txt", "52.5 0 31.5\n0 52.5 23.5\n0 0 1\n");
}

TEST_F(AreasCommand, SaysThatAWordWasNotSeen) {
  const std::string home = scratch_ / "home";
  writeSmallModel(scratch_ / "small", "scale = 0.5");
  writeTurn(home);
  const auto find = [&](const std::string& word) {
    const auto found = run({"areas", "find", home, "-o", file_, "--overwrite", "--model", scratch_ / "small",
                            "--word", word, "--json"});
    EXPECT_EQ(found.exitCode, 0) << found.err;
    return nlohmann::json::parse(found.out)["word"];
  };
  EXPECT_GT(find("word 1")["p"], 0.2);
  EXPECT_EQ(find("word 1")["area"], 0);
  EXPECT_EQ(find("word 0")["p"], 0);
  EXPECT_TRUE(find("word 0")["position"].is_null()) << "not the first cell of the floor";
  EXPECT_TRUE(find("word 0")["area"].is_null());
}

TEST_F(AreasCommand, OfAMapAreNamedSplitAndMerged) {
  const std::string home = scratch_ / "home", map = scratch_ / "home.estancia";
  writeSmallModel(scratch_ / "small", "scale = 0.5");
  writeTurn(home);
  const std::vector<std::string> mapping{"map",        home, "-o", map, "--model", scratch_ / "small",
                                         "--overwrite"};
  ASSERT_EQ(run(mapping).exitCode, 0);
  EXPECT_EQ(readWorld(map).areas.size(), 1U);
  EXPECT_EQ(run({"areas", "split", map, "2", "0.1", "2", "3.9"}).exitCode, 0);
  EXPECT_EQ(readWorld(map).areas.size(), 2U);
  EXPECT_EQ(run({"name", map, "1", "Ana's \"room\""}).exitCode, 0);
  EXPECT_EQ(readWorld(map).areas[1].displayName(), "Ana's \"room\"");
  EXPECT_EQ(run({"areas", "merge", map, "0", "Ana's \"room\""}).exitCode, 0);
  ASSERT_EQ(readWorld(map).areas.size(), 1U);
  EXPECT_EQ(readWorld(map).areas[0].displayName(), "Ana's \"room\"");
  const auto list = nlohmann::json::parse(run({"areas", "list", map, "--json"}).out);
  ASSERT_EQ(list["areas"].size(), 1U);
  EXPECT_EQ(list["areas"][0]["given_name"], "Ana's \"room\"");
  EXPECT_EQ(list["areas"][0]["objects"], 0);
  EXPECT_THAT(run({"name", map, "cellar", "x"}), FailsWith(ErrorCode::unknownName));
  EXPECT_EQ(run({"name", map, "0", ""}).exitCode, 0) << "takes the name away";
  EXPECT_EQ(readWorld(map).areas[0].givenName, "");
  EXPECT_THAT(run({"name", map, "0", std::string(121, 'x')}), FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT(run({"name", map, "0", "a\u202eb"}), FailsWith(ErrorCode::invalidInput));
  EXPECT_EQ(readWorld(map).areas[0].givenName, "");
  EXPECT_THAT(run({"name", map, "", "x"}), FailsWith(ErrorCode::invalidOption));
}

}  // namespace
}  // namespace estancia::test
