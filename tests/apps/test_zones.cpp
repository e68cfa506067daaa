// `estancia zones find`, and the commands that take its file, as a user runs them.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "estancia/sequences/descriptor_sequence.hpp"
#include "support/errors.hpp"
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
    std::vector<std::string> arguments{"zones", "find", words_, "-o", file_, "--overwrite", "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto result = run(arguments);
    EXPECT_EQ(result.exitCode, 0) << result.err;
    return json::parse(result.out, nullptr, false);
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
  const auto lines = run({"zones", "find", words_, "-o", file_, "--stream", "--json", "--count", "3"});
  ASSERT_EQ(lines.exitCode, 0) << lines.err;
  std::istringstream in(lines.out);
  std::string line;
  for (std::size_t i = 0; i < 40; ++i) {
    ASSERT_TRUE(std::getline(in, line));
    EXPECT_EQ(json::parse(line)["image"], "frame " + std::to_string(i));
    EXPECT_GE(json::parse(line)["zone"], 0);
  }
  std::getline(in, line);
  const json end = json::parse(line);
  EXPECT_EQ(end["exact"]["images"], 40);
  EXPECT_EQ(end["exact"]["ari"], 1) << "few images are all kept";
  json exact = zones({"--count", "3"});
  EXPECT_EQ(end["zones"], exact["zones"]);
}

TEST_F(ZonesCommand, TakesTheWordsOfAMap) {
  ASSERT_EQ(run({"map", words_, "-o", map_}).exitCode, 0);
  const auto ofMap = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"zones",       "find",  map_, "-o", scratch_ / "map.zones",
                                       "--overwrite", "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto result = run(arguments);
    EXPECT_EQ(result.exitCode, 0) << result.err;
    return json::parse(result.out, nullptr, false)["zones"];
  };
  EXPECT_EQ(ofMap({"--set", "zones.reach=0"}), zones()["zones"]);
  EXPECT_EQ(ofMap({}), zones({"--set", "zones.reach=0.5"})["zones"]) << "a map is a run";
  expectError({"zones", "find", map_, "-o", scratch_ / "c.zones", "--model", "inception-v3"},
              ErrorCode::invalidOption);
}

TEST_F(ZonesCommand, LetsAskSayTheZone) {
  ASSERT_EQ(run({"map", words_, "-o", map_}).exitCode, 0);
  zones();
  const auto answer = run({"ask", map_, "stove", "--zones", file_, "--json"});
  ASSERT_EQ(answer.exitCode, 0) << answer.err;
  const json told = json::parse(answer.out);
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
}

TEST_F(ZonesCommand, ReplacesZonesOnlyAndOnlyWhenTold) {
  zones();
  expectError({"zones", "find", words_, "-o", file_}, ErrorCode::fileExists);
  const std::string words = readFile(words_);
  expectError({"zones", "find", words_, "-o", words_, "--overwrite"}, ErrorCode::fileExists);
  EXPECT_EQ(readFile(words_), words);
  expectError({"zones", "find", words_, "-o", scratch_ / "none/home.zones"}, ErrorCode::fileNotFound);
}

}  // namespace
}  // namespace estancia::test
