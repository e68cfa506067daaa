// `estancia ask`, `route`, `export` and `report` on a map with areas and objects.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

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
  for (const char* fact : {"object 1 ", "60.0 %", "(2.20, 6.40, 0.80) m", "on the dining table",
                           "in area 0 (kitchen)", "frame_0.png to frame_1.png", "place 0 "})
    EXPECT_THAT(said.out, HasSubstr(fact));
  EXPECT_LT(said.out.find("object 1"), said.out.find("place 0"));
  EXPECT_THAT(run({"ask", map_, "mug"}).out, HasSubstr("No object has it as its best word"));
  EXPECT_THAT(run({"ask", map_, "kitchen"}).out, HasSubstr("area 0 (kitchen): 32.0 m²"));
  EXPECT_THAT(run({"ask", map_, "umbrella", "--max-objects", "1"}).out, testing::Not(HasSubstr("object 2")));

  const json answer = json::parse(run({"ask", map_, "coffee mug", "--json"}).out);
  EXPECT_EQ(answer["objects"][0]["id"], 1);
  EXPECT_EQ(answer["objects"][0]["image"], "frame_1.png");
  EXPECT_FALSE(answer["objects"][0].contains("image_file"));
  EXPECT_EQ(answer["places"][0]["area"]["name"], "kitchen");
  EXPECT_THAT(run({"ask", map_, "coridor"}).out, HasSubstr("area 2 (corridor"))
      << "its spelling is corrected";
  const WithoutWordNet plain;
  const auto none = run({"ask", map_, "coridor", "--json"});
  EXPECT_EQ(none.exitCode, 1);
  EXPECT_EQ(json::parse(none.out)["near_spellings"][0], "corridor");
}

TEST_F(WorldCommand, ReportsStartAtTheLabelThatIsMeant) {
  const std::vector<std::string> page{"report", map_, "-o", scratch_ / "page.html", "--overwrite", "--label"};
  const auto reported = [&page](const std::string& words) {
    std::vector<std::string> arguments = page;
    arguments.push_back(words);
    return run(arguments);
  };
  EXPECT_THAT(reported("coffee mug").err, testing::Not(HasSubstr("no label is called")));
  EXPECT_THAT(reported("crockery").err, HasSubstr("no label is called \"crockery\": the page starts as the "
                                                  "heat map of cup ("));
  EXPECT_THAT(reported("xyzzy"), FailsWith(ErrorCode::unknownName, "xyzzy", "estancia ask"));
  const WithoutWordNet plain;
  EXPECT_THAT(reported("crockery"), FailsWith(ErrorCode::unknownName, "crockery"));
}

TEST_F(WorldCommand, UnderstandsWordsThatNoLabelHas) {
  const auto said = run({"ask", map_, "something made of crockry"});
  EXPECT_EQ(said.exitCode, 0) << said.err;
  EXPECT_THAT(said.out, HasSubstr("crockery → "));
  EXPECT_THAT(said.out, HasSubstr("cup ("));
  const json answer = json::parse(run({"ask", map_, "crockry", "--json"}).out);
  EXPECT_EQ(answer["corrected"], "crockery");
  EXPECT_EQ(answer["matches"][0]["reason"], "a kind of crockery");
  EXPECT_EQ(run({"route", map_, "--from", "0", "--to", "crockery"}).exitCode, 0);
  EXPECT_EQ(run({"ask", map_, "xyzzy"}).exitCode, 1);

  const WithoutWordNet names;
  const auto plain = run({"ask", map_, "crockery"}), named = run({"ask", map_, "cup"});
  EXPECT_EQ(plain.exitCode, 1);
  EXPECT_THAT(plain.out, HasSubstr("ESTANCIA_WORDNET"));
  EXPECT_EQ(named.exitCode, 0) << "names need no WordNet";
}

TEST_F(WorldCommand, LooksUpOtherLanguagesInADictionary) {
  const std::string german = scratch_ / "german.txt";
  writeFile(german, "regenschirm\tumbrella\nküche\tmug\n");
  EXPECT_THAT(run({"ask", map_, "Regenschirm", "--dictionary", german}).out,
              HasSubstr("umbrella → umbrella"));
  EXPECT_THAT(run({"route", map_, "--from", "0", "--to", "Regenschirm", "--dictionary", german}).out,
              HasSubstr("umbrella"));
  writeFile(german, "kitchen\tumbrella\n");
  EXPECT_THAT(run({"ask", map_, "kitchen", "--dictionary", german}).out, HasSubstr("area 0 (kitchen"))
      << "names in the map go first";
  writeFile(german, "kitchen\n");
  EXPECT_THAT(run({"ask", map_, "kitchen", "--dictionary", german}),
              FailsWith(ErrorCode::malformedFile, "line 1"));
}

TEST_F(WorldCommand, NamesAreasByTheNamesOfRoomsAlone) {
  const auto said = run({"classify", "name", map_, "--rooms", "kitchen,dining room,bathroom"});
  EXPECT_EQ(said.exitCode, 0) << said.err;
  EXPECT_THAT(said.out, HasSubstr("place 0"));
  EXPECT_THAT(said.out, HasSubstr("area 0"));
  EXPECT_EQ(readMap(map_).predictions->rooms,
            (std::vector<std::string>{"kitchen", "dining room", "bathroom"}));
  EXPECT_TRUE(readMap(map_).predictions->areListed);
  EXPECT_EQ(run({"classify", "name", map_}).exitCode, 0);
  EXPECT_FALSE(readMap(map_).predictions->areListed);
  EXPECT_THAT(run({"classify", "name", map_, "--rooms", "kitchen,xyzzy"}),
              FailsWith(ErrorCode::unknownName, "xyzzy"));
  EXPECT_THAT(run({"classify", "name", map_, "--rooms", "kitchen"}), FailsWith(ErrorCode::insufficientData));
  EXPECT_NE(run({"classify", "name"}).exitCode, 0);
  EXPECT_THAT(run({"classify", "name", scratch_ / "missing.estancia"}), FailsWith(ErrorCode::fileNotFound));
  const WithoutWordNet names;
  EXPECT_THAT(run({"classify", "name", map_}), FailsWith(ErrorCode::missingDependency, "ESTANCIA_WORDNET"));
}

TEST_F(WorldCommand, WritesTheImagesOfAnswers) {
  const fs::path folder = scratch_ / "images";
  const auto answer = run({"ask", map_, "mug", "--images", folder, "--json"});
  EXPECT_EQ(answer.exitCode, 0) << answer.err;
  EXPECT_EQ(json::parse(answer.out)["objects"][1]["image_file"], (folder / "object-1.jpg").string());
  EXPECT_FALSE(json::parse(answer.out)["objects"][0].contains("image_file")) << "object 2 has none";
  EXPECT_EQ(readFile(folder / "object-1.jpg"), "\xFF\xD8\xFF\xD9");
  EXPECT_THAT(run({"ask", map_, "mug", "--images", folder}),
              FailsWith(ErrorCode::fileExists, "object-1.jpg"));
  EXPECT_EQ(run({"ask", map_, "mug", "--images", folder, "--overwrite"}).exitCode, 0);
  EXPECT_THAT(run({"ask", map_, "mug", "--images", map_}), FailsWith(ErrorCode::fileUnwritable, map_));
}

TEST_F(WorldCommand, RoutesToWhereAnObjectIsFaced) {
  const auto said = run({"route", map_, "--from", "3", "--to", "coffee mug"});
  EXPECT_EQ(said.exitCode, 0) << said.err;
  for (const char* fact : {"object 1 (60.0 %)", "on the dining table", "3 (Ana's \"room\")", "0 (kitchen)",
                           "(2.00, 4.00) m", "yaw 85°", "frame_1.png", "2.4 m"})
    EXPECT_THAT(said.out, HasSubstr(fact));
  const json route = json::parse(run({"route", map_, "--from", "3", "--to", "coffee mug", "--json"}).out);
  EXPECT_EQ(route["nodes"], json({3, 1, 0}));
  EXPECT_EQ(route["pose"]["frame"], "frame_1.png");
  EXPECT_EQ(route["object"]["id"], 1);
  EXPECT_THAT(run({"route", map_, "--from", "0", "--to", "mug"}).err, HasSubstr("no object is likely"));
}

TEST_F(WorldCommand, RoutesAroundAndThroughAreas) {
  const std::string home = scratch_ / "round.estancia";
  writeWorld(sampleRoundTrip(), home);
  const auto nodes = [&home](std::vector<std::string> preferences) {
    std::vector<std::string> arguments{"route", home, "--from", "0", "--to", "Ana's \"room\"", "--json"};
    arguments.insert(arguments.end(), preferences.begin(), preferences.end());
    return json::parse(run(arguments).out)["nodes"];
  };
  EXPECT_EQ(nodes({}), json({0, 1, 3}));
  EXPECT_EQ(nodes({"--avoid", "bathtub"}), json({0, 2, 3}));
  EXPECT_EQ(nodes({"--prefer", "corridor", "--prefer", "kitchen", "--prefer-factor", "0.1"}),
            json({0, 2, 3}));
  EXPECT_EQ(nodes({"--avoid", "bathtub", "--avoid", "corridor"}), json({0, 1, 3}));
  EXPECT_EQ(nodes({"--avoid", "1", "--avoid-factor", "1"}), json({0, 1, 3}));
  EXPECT_THAT(run({"route", home, "--from", "0", "--to", "1", "--avoid", "bathtub"}).out,
              HasSubstr("in \"bathtub\": the goal is there"));
  EXPECT_THAT(run({"route", map_, "--from", "0", "--to", "3", "--avoid", "99"}),
              FailsWith(ErrorCode::unknownName, "99", "corridor"));
  const WithoutWordNet plain;
  EXPECT_THAT(run({"route", map_, "--from", "0", "--to", "3", "--avoid", "cellar"}),
              FailsWith(ErrorCode::unknownName, "cellar", "corridor", "WORDNET"));
  EXPECT_THAT(run({"route", map_, "--from", "0", "--to", "xylophone"}).out, HasSubstr("WORDNET"));
}

TEST_F(WorldCommand, ExportsItsLayers) {
  for (const char* format : {"rooms", "spark-dsg", "nav2", "graphml", "json"}) {
    const auto exported = run({"export", map_, "--format", format});
    EXPECT_EQ(exported.exitCode, 0) << exported.err;
    EXPECT_EQ(exported.out, exportWorld(readWorld(map_), format)) << format;
  }
  EXPECT_THAT(run({"export", map_, "--format", "rooms", "--frame", "odom"}),
              FailsWith(ErrorCode::invalidOption, "--frame"));
}

TEST_F(WorldCommand, ReportsThePlanWithTheWaysOfRoute) {
  const fs::path page = scratch_ / "home.html";
  ASSERT_EQ(run({"report", map_, "-o", page, "--from", "3"}).exitCode, 0);
  const std::string html = readFile(page);
  for (const char* part : {"id=\"world\"", "id=\"area-3\"", "id=\"object-5\"", "id=\"image-1\""})
    EXPECT_THAT(html, HasSubstr(part));
  EXPECT_THAT(html, HasSubstr("\"grammar\":")) << "the search understands words that no label has";
  const json route = json::parse(run({"route", map_, "--from", "3", "--to", "coffee mug", "--json"}).out);
  const double length = route["driven"]["length"];
  EXPECT_THAT(html, HasSubstr(fmt::format("\"length\":{:.2f}", length)));
  EXPECT_THAT(run({"route", map_, "--from", "3", "--to", "coffee mug"}).out,
              HasSubstr(fmt::format("{:.1f} m as driven", length)));
  EXPECT_THAT(run({"report", map_, "-o", scratch_ / "no.html", "--from", "99"}),
              FailsWith(ErrorCode::unknownName, "99"));
  WorldMap bare = sampleWorld();
  bare.objects.clear();
  writeWorld(bare, scratch_ / "bare.estancia");
  EXPECT_THAT(run({"report", scratch_ / "bare.estancia", "-o", scratch_ / "no.html", "--from", "3"}),
              FailsWith(ErrorCode::insufficientData, "--from"));
}

TEST_F(WorldCommand, IsEvaluatedBesideTheTruthAboutItsDrive) {
  const fs::path home = scratch_ / "home";
  writeSampleHome(home);
  const auto said = run({"evaluate", map_, "--truth", home, "--classes", home / "things.toml"});
  EXPECT_EQ(said.exitCode, 0) << said.err;
  for (const char* fact : {"V-measure", "Trajectory error [m]", "Recall", "0.750", "Recall, furniture"})
    EXPECT_THAT(said.out, HasSubstr(fact));
  const json measures =
      json::parse(run({"evaluate", map_, "--truth", home, "--classes", home / "things.toml", "--json"}).out);
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
  EXPECT_FALSE(plain.contains("object_names"));
}

TEST_F(WorldCommand, SaysWhatIsWrongWithTheTruth) {
  const fs::path home = scratch_ / "home";
  writeSampleHome(home);
  const std::string classes = home / "things.toml";
  EXPECT_THAT(run({"evaluate", map_, "--classes", classes}), FailsWith(ErrorCode::invalidOption, "--truth"));
  writeFile(scratch_ / "bad.toml", "[words]\nmug = 3\n");
  EXPECT_THAT(run({"evaluate", map_, "--truth", home, "--classes", scratch_ / "bad.toml"}),
              FailsWith(ErrorCode::malformedFile, "bad.toml:2"));
  fs::remove(home / "visible.csv");
  fs::remove(home / "instances.csv");
  EXPECT_THAT(run({"evaluate", map_, "--truth", home, "--classes", classes}),
              FailsWith(ErrorCode::fileNotFound, "instances.csv"));
  EXPECT_EQ(run({"evaluate", map_, "--truth", home}).exitCode, 0) << "rooms and trajectory are there";
  fs::rename(home / "rgb/frame_3.png", home / "rgb/other.png");
  fs::rename(home / "depth/frame_3.png", home / "depth/other.png");
  EXPECT_THAT(run({"evaluate", map_, "--truth", home}), FailsWith(ErrorCode::mismatch, "frame_3.png"));
}

}  // namespace
}  // namespace estancia::test
