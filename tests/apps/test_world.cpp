// `estancia ask`, `route`, `export` and `report` on a map with areas and objects.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "apps/json_of.hpp"
#include "estancia/world_query/export_world.hpp"
#include "support/errors.hpp"
#include "support/sample_home.hpp"
#include "support/sample_world.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

class WorldCommand : public testing::Test {
 protected:
  void SetUp() override { writeWorld(sampleWorld(), map_); }

  ScratchFolder scratch_;
  const std::string map_ = scratch_ / "home.estancia";
};

TEST_F(WorldCommand, AsksForObjectsAreasAndPlaces) {
  const auto said = run({"ask", map_, "coffee mug"});
  EXPECT_EQ(said.exitCode, 0) << said.err;
  EXPECT_LT(said.out.find("object 1"), said.out.find("place 0"));
  const json answer = json::parse(run({"ask", map_, "coffee mug", "--json"}).out);
  EXPECT_EQ(answer["objects"][0]["id"], 1);
  EXPECT_EQ(answer["objects"][0]["image"], "frame_1.png");
  EXPECT_FALSE(answer["objects"][0].contains("image_file"));
  EXPECT_EQ(answer["places"][0]["area"]["name"], "kitchen");
  EXPECT_EQ(json::parse(run({"ask", map_, "umbrella", "--max-objects", "1", "--json"}).out)["objects"].size(),
            1U);
  EXPECT_EQ(run({"ask", map_, "coridor"}).exitCode, 0) << "its spelling is corrected";
  const WithoutWordNet plain;
  const auto none = run({"ask", map_, "coridor", "--json"});
  EXPECT_EQ(none.exitCode, 1);
  EXPECT_EQ(json::parse(none.out)["near_spellings"][0], "corridor");
}

/// The one test of the wording: what people read when they ask, with where it is, how sure and what to do.
TEST_F(WorldCommand, AnswersPeopleInWords) {
  const auto says = [](const std::vector<std::string>& arguments, const std::vector<std::string>& facts) {
    const CommandResult result = run(arguments);
    for (const std::string& fact : facts) EXPECT_THAT(result.out + result.err, HasSubstr(fact));
  };
  says({"ask", map_, "coffee mug"}, {"object 1 ", "60.0 %", "(2.20, 6.40, 0.80) m", "on the dining table",
                                     "in area 0 (kitchen)", "frame_0.png to frame_1.png", "place 0 "});
  says({"ask", map_, "mug"}, {"No object has it as its best word"});
  says({"ask", map_, "kitchen"}, {"area 0 (kitchen): 32.0 m²"});
  says({"route", map_, "--from", "3", "--to", "coffee mug"},
       {"object 1 (60.0 %)", "on the dining table", "3 (Ana's \"room\")", "0 (kitchen)", "(2.00, 4.00) m",
        "yaw 85°", "frame_1.png", "2.4 m"});
  says({"route", map_, "--from", "0", "--to", "mug"}, {"no object is likely"});
  const WithoutWordNet plain;
  says({"ask", map_, "crockery"}, {"ESTANCIA_WORDNET"});
}

TEST_F(WorldCommand, LooksUpOtherLanguagesInADictionary) {
  const std::string german = scratch_ / "german.txt";
  const auto ask = [&](const std::string& words) {
    return run({"ask", map_, words, "--dictionary", german, "--json"});
  };
  writeFile(german, "regenschirm\tumbrella\nküche\tmug\n");
  EXPECT_EQ(json::parse(ask("Regenschirm").out)["objects"][0]["name"], "umbrella");
  EXPECT_EQ(run({"route", map_, "--from", "0", "--to", "Regenschirm", "--dictionary", german}).exitCode, 0);
  writeFile(german, "kitchen\tumbrella\n");
  EXPECT_EQ(json::parse(ask("kitchen").out)["areas"][0]["name"], "kitchen") << "names in the map go first";
  writeFile(german, "kitchen\n");
  EXPECT_THAT(ask("kitchen"), FailsWith(ErrorCode::malformedFile));
}

TEST_F(WorldCommand, WritesTheImagesOfAnswers) {
  const fs::path folder = scratch_ / "images";
  const auto answer = run({"ask", map_, "mug", "--images", folder, "--json"});
  EXPECT_EQ(answer.exitCode, 0) << answer.err;
  EXPECT_EQ(json::parse(answer.out)["objects"][1]["image_file"], (folder / "object-1.jpg").string());
  EXPECT_FALSE(json::parse(answer.out)["objects"][0].contains("image_file")) << "object 2 has none";
  EXPECT_EQ(readFile(folder / "object-1.jpg"), "\xFF\xD8\xFF\xD9");
  EXPECT_THAT(run({"ask", map_, "mug", "--images", folder}), FailsWith(ErrorCode::fileExists));
  EXPECT_EQ(run({"ask", map_, "mug", "--images", folder, "--overwrite"}).exitCode, 0);
  EXPECT_THAT(run({"ask", map_, "mug", "--images", map_}), FailsWith(ErrorCode::fileUnwritable));
}

TEST_F(WorldCommand, RoutesAroundAndThroughAreas) {
  const std::string home = scratch_ / "round.estancia";
  writeWorld(sampleRoundTrip(), home);
  const auto nodes = [&home](const std::vector<std::string>& preferences) {
    return jsonOf(
        run({"route", home, "--from", "0", "--to", "Ana's \"room\"", "--json"}, preferences))["nodes"];
  };
  EXPECT_EQ(nodes({}), json({0, 1, 3}));
  EXPECT_EQ(nodes({"--avoid", "bathtub"}), json({0, 2, 3}));
  EXPECT_EQ(nodes({"--prefer", "corridor", "--prefer", "kitchen", "--prefer-factor", "0.1"}),
            json({0, 2, 3}));
  EXPECT_EQ(nodes({"--avoid", "1", "--avoid-factor", "1"}), json({0, 1, 3}));
  EXPECT_THAT(run({"route", map_, "--from", "0", "--to", "3", "--avoid", "99"}),
              FailsWith(ErrorCode::unknownName));
}

TEST_F(WorldCommand, ExportsItsLayers) {
  for (const char* format : {"rooms", "spark-dsg", "nav2", "graphml", "json"}) {
    const auto exported = run({"export", map_, "--format", format});
    EXPECT_EQ(exported.exitCode, 0) << exported.err;
    EXPECT_EQ(exported.out, exportWorld(readWorld(map_), format)) << format;
  }
  EXPECT_THAT(run({"export", map_, "--format", "rooms", "--frame", "odom"}),
              FailsWith(ErrorCode::invalidOption));
}

TEST_F(WorldCommand, ReportsThePlanWithTheWaysOfRoute) {
  const fs::path page = scratch_ / "home.html";
  ASSERT_EQ(run({"report", map_, "-o", page, "--from", "3"}).exitCode, 0);
  const std::string html = readFile(page);
  EXPECT_NE(html.find("\"grammar\":"), std::string::npos) << "the search understands words that no label has";
  const json route = json::parse(run({"route", map_, "--from", "3", "--to", "coffee mug", "--json"}).out);
  EXPECT_EQ(route["nodes"], json({3, 1, 0}));
  EXPECT_EQ(route["pose"]["frame"], "frame_1.png") << "where it is faced";
  EXPECT_EQ(route["object"]["id"], 1);
  const double length = route["driven"]["length"];
  EXPECT_NE(html.find(fmt::format("\"length\":{:.2f}", length)), std::string::npos);
  EXPECT_THAT(run({"report", map_, "-o", scratch_ / "no.html", "--from", "99"}),
              FailsWith(ErrorCode::unknownName));
  WorldMap bare = sampleWorld();
  bare.objects.clear();
  writeWorld(bare, scratch_ / "bare.estancia");
  EXPECT_THAT(run({"report", scratch_ / "bare.estancia", "-o", scratch_ / "no.html", "--from", "3"}),
              FailsWith(ErrorCode::insufficientData));
}

TEST_F(WorldCommand, IsEvaluatedBesideTheTruthAboutItsDrive) {
  const fs::path home = scratch_ / "home";
  writeSampleHome(home);
  const json measures =
      jsonOf(run({"evaluate", map_, "--truth", home, "--classes", home / "things.toml", "--json"}));
  EXPECT_EQ(measures["object_recall"], 0.75);
  EXPECT_EQ(measures["object_precision"], 0.5);
  EXPECT_EQ(measures["object_recall_furniture"], 0.5);
  EXPECT_NEAR(measures["object_names"], 2.0 / 3, 1e-9);
  EXPECT_NEAR(measures["trajectory_rmse"], 0, 1e-5);
  EXPECT_GT(measures["area_v_measure"], 0.5);
  EXPECT_EQ(measures["nodes"], 4);
  const json plain = json::parse(run({"evaluate", map_, "--truth", home, "--json"}).out);
  EXPECT_EQ(plain["object_recall"], 0.75);
  EXPECT_FALSE(plain.contains("object_recall_furniture")) << "all are things";
}

}  // namespace
}  // namespace estancia::test
