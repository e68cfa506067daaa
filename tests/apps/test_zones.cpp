// `estancia zones` and `estancia areas` as a user runs them.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <regex>

#include "apps/json_of.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"
#include "estancia/world_file/world_map.hpp"
#include "support/errors.hpp"
#include "support/floor_scene.hpp"
#include "support/model_support.hpp"
#include "support/support.hpp"
#include "support/synthetic.hpp"

namespace estancia::test {
namespace {

using nlohmann::json;

class ZonesCommand : public testing::Test {
 protected:
  void SetUp() override {
    SyntheticPlaces places(3, 12, 0.4);
    DescriptorSequence recording{Vocabulary({"stove", "fridge", "tub", "sink", "bed", "sofa", "desk", "lamp",
                                             "plant", "door", "window", "chair"}),
                                 "test",
                                 {},
                                 DescriptorMatrix(12)};
    const std::vector<std::string> rooms{"kitchen", "bath", "bedroom"};
    for (const std::size_t place : {0U, 1U, 2U, 0U})
      for (int i = 0; i < 10; ++i) {
        Frame frame;
        frame.name = "frame " + std::to_string(recording.frames.size());
        frame.room = rooms[place];
        recording.frames.push_back(frame);
        recording.descriptors.append(places.image(place));
      }
    writeDescriptors(recording, words_);
  }

  json zones(const std::vector<std::string>& more = {}) {
    return jsonOf(run({"zones", "find", words_, "-o", file_, "--overwrite", "--json"}, more));
  }

  static void expectError(const std::vector<std::string>& arguments, ErrorCode code) {
    const auto result = run(arguments);
    EXPECT_THAT(result, FailsWith(code));
    EXPECT_EQ(result.out, "");
  }

  const WithoutWordNet names_;  // which would be read by each command
  ScratchFolder scratch_;
  const std::string words_ = scratch_ / "home.labels", file_ = scratch_ / "home.zones",
                    map_ = scratch_ / "home.estancia";
};

TEST_F(ZonesCommand, FindsAndNamesTheRooms) {
  const json found = zones({"--count", "3"});
  ASSERT_EQ(found["zones"].size(), 3U);
  EXPECT_EQ(found["zones"][0]["room"], "kitchen");
  EXPECT_EQ(found["zones"][0]["images"], 20);
  EXPECT_EQ(found["zones"][0]["share"], 0.5);
  EXPECT_EQ(found["measures"]["v_measure"], 1);
  EXPECT_EQ(found["rooms"]["kitchen"]["images"], 20);
}

TEST_F(ZonesCommand, FollowsAStreamAndSaysHowFarItIsFromTheExactResult) {
  const auto lines =
      jsonLinesOf(run({"zones", "find", words_, "-o", file_, "--stream", "--json", "--count", "3"}));
  ASSERT_EQ(lines.size(), 41U);
  for (std::size_t i = 0; i < 40; ++i) {
    EXPECT_EQ(lines[i]["image"], "frame " + std::to_string(i));
    EXPECT_GE(lines[i]["zone"], 0);
  }
  const json& end = lines[40];
  EXPECT_EQ(end["exact"]["images"], 40);
  EXPECT_EQ(end["exact"]["ari"], 1) << "few images are all kept";
  json exact = zones({"--count", "3"});
  EXPECT_EQ(end["zones"], exact["zones"]);
}

TEST_F(ZonesCommand, TakesTheWordsOfAMap) {
  ASSERT_EQ(run({"map", words_, "-o", map_}).exitCode, 0);
  const auto ofMap = [&](const std::vector<std::string>& more) {
    return jsonOf(
        run({"zones", "find", map_, "-o", scratch_ / "map.zones", "--overwrite", "--json"}, more))["zones"];
  };
  EXPECT_EQ(ofMap({"--set", "zones.reach=0"}), zones()["zones"]);
  EXPECT_EQ(ofMap({}), zones({"--set", "zones.reach=0.5"})["zones"]) << "a map is a run";
  expectError({"zones", "find", map_, "-o", scratch_ / "c.zones", "--model", "inception-v3"},
              ErrorCode::invalidOption);
}

TEST_F(ZonesCommand, LetsAskSayTheZone) {
  ASSERT_EQ(run({"map", words_, "-o", map_}).exitCode, 0);
  zones();
  const json told = jsonOf(run({"ask", map_, "stove", "--zones", file_, "--json"}));
  ASSERT_FALSE(told["places"].empty());
  for (const json& place : told["places"]) {
    const json found = json::parse(readFile(file_))["zones"][place["zone"]["id"].get<std::size_t>()];
    EXPECT_EQ(found["room"], place["room"]) << "the zone of the place's own room";
    EXPECT_EQ(found["name"], place["zone"]["name"]);
  }
  EXPECT_FALSE(json::parse(run({"ask", map_, "stove", "--json"}).out)["places"][0].contains("zone"));

  writeFile(scratch_ / "other.csv", "image,stove,tub\na,0.5,0.5\nb,0.1,0.9\n");
  ASSERT_EQ(run({"zones", "find", scratch_ / "other.csv", "-o", scratch_ / "other.zones"}).exitCode, 0);
  expectError({"ask", map_, "stove", "--zones", scratch_ / "other.zones"}, ErrorCode::mismatch);
  expectError({"ask", map_, "stove", "--zones", map_}, ErrorCode::unsupportedFile);
}

TEST_F(ZonesCommand, IsEvaluatedAndExported) {
  zones({"--count", "3"});
  const auto measures = run({"evaluate", file_, "--json"});
  ASSERT_EQ(measures.exitCode, 0) << measures.err;
  EXPECT_EQ(json::parse(measures.out)["zones"], 3);
  EXPECT_EQ(json::parse(measures.out)["v_measure"], 1);
  expectError({"evaluate", file_, words_}, ErrorCode::unsupportedFile);

  const auto rooms = run({"export", file_, "--format", "rooms", "--max-words", "2"});
  ASSERT_EQ(rooms.exitCode, 0) << rooms.err;
  const json exported = json::parse(rooms.out);
  EXPECT_EQ(exported.size(), 3U);
  EXPECT_EQ(exported["kitchen"]["images"], 20);
  EXPECT_EQ(exported["kitchen"]["words"].size(), 2U);
  expectError({"export", file_, "--format", "nav2"}, ErrorCode::unsupportedFile);
  ASSERT_EQ(run({"map", words_, "-o", map_}).exitCode, 0);
  expectError({"export", map_, "--format", "rooms"}, ErrorCode::unsupportedFile);
}

TEST_F(ZonesCommand, AreShownByThemselvesAndOverAMap) {
  ASSERT_EQ(run({"map", words_, "-o", map_}).exitCode, 0);
  zones({"--count", "3"});
  const std::string page = scratch_ / "page.html";
  ASSERT_EQ(run({"report", file_, "-o", page, "--map", map_}).exitCode, 0);
  EXPECT_NE(readFile(page).find("<dt>zones</dt><dd>3</dd>"), std::string::npos);
  ASSERT_EQ(run({"report", map_, "-o", page, "--zones", file_, "--overwrite"}).exitCode, 0);
  EXPECT_NE(readFile(page).find("In zone 0, "), std::string::npos);
  expectError({"report", map_, "-o", scratch_ / "no.html", "--zones", map_}, ErrorCode::unsupportedFile);
  expectError({"report", file_, "-o", scratch_ / "no.html", "--label", "bed"}, ErrorCode::invalidOption);
  expectError({"evaluate", file_, "--original-extent", "30"}, ErrorCode::invalidOption);
  expectError({"evaluate", map_, "--original-extent", "nan"}, ErrorCode::invalidOption);
  expectError({"report", words_, "-o", scratch_ / "no.html", "--map", map_}, ErrorCode::mismatch);
}

TEST_F(ZonesCommand, ReplacesZonesOnlyAndOnlyWhenTold) {
  zones();
  expectError({"zones", "find", words_, "-o", file_}, ErrorCode::fileExists);
  const std::string words = readFile(words_);
  expectError({"zones", "find", words_, "-o", words_, "--overwrite"}, ErrorCode::fileExists);
  EXPECT_EQ(readFile(words_), words);
  expectError({"zones", "find", words_, "-o", scratch_ / "none/home.zones"}, ErrorCode::fileNotFound);
}

using AreasCommand = ZonesCommand;

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
  ASSERT_EQ(run({"map", words_, "-o", map_}).exitCode, 0);
  zones({"--count", "2"});
  EXPECT_TRUE(
      jsonLinesOf(run({"localize", map_, words_, "--zones", file_, "--json"}))[0].contains("belief_zone"));
  writeFile(file_, std::regex_replace(readFile(file_), std::regex("\"frame "), "\"image "));
  EXPECT_THAT(run({"localize", map_, words_, "--zones", file_}), FailsWith(ErrorCode::mismatch));
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
    return jsonOf(run({"areas", "find", home, "-o", file_, "--overwrite", "--model", scratch_ / "small",
                       "--word", word, "--json"}))["word"];
  };
  EXPECT_GT(find("word 1")["p"], 0.2);
  EXPECT_EQ(find("word 1")["area"], 0);
  EXPECT_EQ(find("word 0")["p"], 0);
  EXPECT_TRUE(find("word 0")["position"].is_null()) << "not the first cell of the floor";
  EXPECT_TRUE(find("word 0")["area"].is_null());
}

TEST_F(AreasCommand, OfAMapAreNamedSplitAndMerged) {
  const std::string home = scratch_ / "home", map = map_;
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
  const auto list = json::parse(run({"areas", "list", map, "--json"}).out);
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
