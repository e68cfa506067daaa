// Objects, areas and places that a word means.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/world_query/ask_world.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "estancia/map_file/places.hpp"
#include "estancia/words/installed_words.hpp"
#include "estancia/world_query/world_json.hpp"
#include "support/errors.hpp"
#include "support/sample_world.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using Json = nlohmann::ordered_json;
using test::FailsWith;
using test::sampleWorld;
using test::ScratchFolder;
using testing::ElementsAre;

std::vector<int> objectsOf(const WorldAnswers& answers) {
  std::vector<int> ids;
  for (const ObjectAnswer& answer : answers.objects) ids.push_back(answer.object);
  return ids;
}

TEST(AskWorld, RanksObjectsByTheSumOfTheMatchedLabels) {
  const WorldAnswers answers = askWorld(sampleWorld(), "mug");
  EXPECT_THAT(answers.labels, ElementsAre(1U)) << "\"mug\" is a synonym of label 1";
  ASSERT_THAT(objectsOf(answers), ElementsAre(2, 1));
  EXPECT_NEAR(answers.objects[0].probability, 0.3, 1e-6);
  EXPECT_EQ(answers.objects[0].rank, 2U);
  EXPECT_EQ(answers.objects[0].label, "cup, mug");
  EXPECT_FALSE(answers.objects[0].isLikely());
  EXPECT_NEAR(answers.objects[1].lift, 0.25 / ((0.25 + 0.3 + 0.01) / 6), 1e-4);

  WorldMap world = sampleWorld();
  world.places.vocabulary =
      Vocabulary({"coffee mug", "beer mug", "umbrella", "dining table, board", "bathtub", "folding chair"});
  world.objects[1].words = {{"beer mug", 0.7F}, {"coffee mug", 0.6F}};
  const WorldAnswers both = askWorld(world, "mug");
  EXPECT_THAT(both.labels, ElementsAre(0U, 1U));
  ASSERT_THAT(objectsOf(both), ElementsAre(1));
  EXPECT_DOUBLE_EQ(both.objects[0].probability, 1);
  EXPECT_EQ(both.objects[0].label, "beer mug");
  EXPECT_TRUE(both.objects[0].isLikely());
}

TEST(AskWorld, LeavesOutWhatIsNoMoreSoThanTheRest) {
  WorldMap world = sampleWorld();
  for (WorldObject& object : world.objects) object.words = {{"umbrella", 0.9F}, {"bathtub", 0.01F}};
  world.objects[2].words = {{"bathtub", 0.5F}, {"umbrella", 0.3F}};
  EXPECT_THAT(objectsOf(askWorld(world, "bathtub")), ElementsAre(2));
  EXPECT_EQ(askWorld(world, "umbrella", 10, 3).objects.size(), 3U);
  EXPECT_EQ(askWorld(world, "umbrella", 2).places.size(), 2U);
  world.objects[2].words = {{"a", 0.4F}, {"b", 0.3F}, {"c", 0.1F},
                            {"d", 0.1F}, {"e", 0.1F}, {"bathtub", 0.1F}};
  EXPECT_THAT(objectsOf(askWorld(world, "bathtub")), testing::Not(testing::Contains(2))) << "sixth word";
}

TEST(AskWorld, FindsWhatPeopleNamedByThatNameAlone) {
  WorldMap world = sampleWorld();
  world.objects[5].givenName = "Rex";
  const WorldAnswers answers = askWorld(world, "REX");
  ASSERT_THAT(objectsOf(answers), ElementsAre(5));
  EXPECT_TRUE(answers.objects[0].isNamed);
  EXPECT_TRUE(answers.objects[0].isLikely());
  EXPECT_DOUBLE_EQ(answers.objects[0].probability, 1);
  EXPECT_TRUE(answers.places.empty()) << "no label means it";
  EXPECT_THAT(objectsOf(askWorld(world, test::hostileName)), ElementsAre(4));
  EXPECT_THAT([&] { askWorld(world, "Ana's lamp"); }, FailsWith(ErrorCode::noAnswer)) << "a part of the name";
  world.objects[0].givenName = "umbrella";
  EXPECT_THAT(objectsOf(askWorld(world, "umbrella")), ElementsAre(0, 3, 2));
  EXPECT_THAT(askWorld(world, "Kitchens").areas, ElementsAre(0));
  EXPECT_THAT(askWorld(world, "bathtub").areas, ElementsAre()) << "found names are words, not names";
}

TEST(AskWorld, AnswersOfPlacesAreThoseOfTheMap) {
  const WorldMap world = sampleWorld();
  const std::vector<PlaceAnswer> places = askWorld(world, "umbrella").places;
  const std::vector<PlaceAnswer> plain = ask(world.places, "umbrella").places;
  ASSERT_EQ(places.size(), plain.size());
  for (std::size_t i = 0; i < plain.size(); ++i) {
    EXPECT_EQ(places[i].node, plain[i].node);
    EXPECT_EQ(places[i].probability, plain[i].probability);
  }
  WorldMap onlyPlaces{.places = test::samplePlaces()};
  onlyPlaces.areaOfFrame.assign(8, -1);
  EXPECT_TRUE(askWorld(onlyPlaces, "umbrella").objects.empty());
  EXPECT_FALSE(
      toJson("umbrella", askWorld(onlyPlaces, "umbrella"), onlyPlaces)["places"][0].contains("area"));
  onlyPlaces.places.nodes.clear();
  EXPECT_THAT([&] { askWorld(onlyPlaces, "umbrella"); }, FailsWith(ErrorCode::insufficientData));
}

TEST(WorldJson, TellsWhereThingsAre) {
  const WorldMap world = sampleWorld();
  const Json json = Json::parse(toJson("mug", askWorld(world, "mug"), world).dump());
  const Json& mug = json["objects"][1];
  EXPECT_EQ(mug["id"], 1);
  EXPECT_EQ(mug["name"], "coffee mug");
  EXPECT_NEAR(mug["probability"].get<double>(), 0.25, 1e-6);
  EXPECT_EQ(mug["label"], "cup, mug");
  EXPECT_EQ(mug["rank"], 2);
  EXPECT_EQ(mug["position"], Json({2.2, 6.4, 0.8}));
  EXPECT_EQ(mug["on"]["name"], "dining table");
  EXPECT_EQ(mug["support"], "object");
  EXPECT_EQ(mug["area"], Json({{"id", 0}, {"name", "kitchen"}}));
  EXPECT_EQ(mug["first_seen"], Json({{"frame", "frame_0.png"}, {"number", 0}, {"drive", 0}, {"time", 0.0}}));
  EXPECT_EQ(mug["last_seen"]["time"], 0.5);
  EXPECT_EQ(mug["image"], "frame_1.png");
  EXPECT_EQ(json["places"][0]["node"], 3);
  EXPECT_EQ(json["places"][0]["area"]["name"], "Ana's \"room\"");
  const Json area = toJson("kitchen", askWorld(world, "kitchen"), world)["areas"][0];
  EXPECT_EQ(area["given_name"], "kitchen");
  EXPECT_EQ(area["center"], Json({2.0, 4.0}));
}

TEST(WorldMap, IsReadAsItWasWritten) {
  const ScratchFolder folder;
  test::writeWorld(sampleWorld(), folder / "home.estancia");
  const WorldMap world = readWorld(folder / "home.estancia");
  ASSERT_EQ(world.objects.size(), 6U);
  EXPECT_EQ(world.areas[3].displayName(), "Ana's \"room\"");
  EXPECT_EQ(areasOfNodes(world), (std::vector<int>{0, 1, 2, 3}));
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_EQ(world.areaOfNode(static_cast<int>(i)), areasOfNodes(world)[i]);
  EXPECT_EQ(supportText(world.objects[1], world), "on the dining table");
  EXPECT_EQ(supportText(world.objects[0], world), "on the floor");
  EXPECT_EQ(supportText(world.objects[5], world), "");
  WorldObject hanging = world.objects[5];
  hanging.support = Support::wall;
  EXPECT_EQ(supportText(hanging, world), "at a wall");
  EXPECT_EQ(toJson(hanging, world)["support"], "wall");
  hanging.support = Support::surface;
  EXPECT_EQ(supportText(hanging, world), "on a surface");
  EXPECT_EQ(toJson(hanging, world)["support"], "surface");
  EXPECT_EQ(readObjectImage(folder / "home.estancia", 1).size(), 4U);
}

TEST(AskWorld, UnderstandsWordsThatNoLabelHas) {
  const WorldMap world = test::sampleWorld();
  const WorldAnswers drinking = askWorld(world, "crockery", 10, 10, installedWordGraph);
  ASSERT_FALSE(drinking.matches.empty());
  EXPECT_EQ(world.places.vocabulary[drinking.matches.front().label], "cup, mug");
  EXPECT_EQ(drinking.matches.front().reason, "a kind of crockery");
  EXPECT_LT(drinking.matches.front().probability, 1);
  ASSERT_FALSE(drinking.objects.empty());
  double expected = 0;
  for (const LabelMatch& match : drinking.matches)
    expected += match.probability *
                world.places.nodes[static_cast<std::size_t>(drinking.places.front().node)].mean[match.label];
  EXPECT_NEAR(drinking.places.front().probability, expected, 1e-6) << "labels weigh as they are meant";
  const WorldAnswers exact = askWorld(world, "cup", 10, 10, installedWordGraph);
  EXPECT_EQ(exact.matches.size(), 1U) << "a label of that name alone";
  EXPECT_EQ(exact.matches.front().probability, 1);
  const WorldAnswers misspelled = askWorld(world, "umbrelas", 10, 10, installedWordGraph);
  EXPECT_EQ(world.places.vocabulary[misspelled.labels.front()], "umbrella");
  EXPECT_THAT(misspelled.corrected, testing::StartsWith("umbrella"));
  for (const std::string words : {"xyzzy", "", "the of", "\x01\x02"})
    EXPECT_THAT([&] { askWorld(world, words, 10, 10, installedWordGraph); }, FailsWith(ErrorCode::noAnswer))
        << words;
  const test::Caught caught = test::caught([&] { askWorld(world, "coridor"); });
  EXPECT_THAT(caught, FailsWith(ErrorCode::noAnswer, "corridor")) << "it suggests given names";
}

TEST(AskWorld, HasNoAnswerForMisspelledWordsOrNone) {
  const WorldMap world = sampleWorld();
  EXPECT_THAT([&] { askWorld(world, "coridor"); }, FailsWith(ErrorCode::noAnswer));
  EXPECT_THAT([&] { askWorld(world, "umbrela"); }, FailsWith(ErrorCode::noAnswer));
  EXPECT_THAT([&] { askWorld(world, ""); }, FailsWith(ErrorCode::noAnswer));
}

}  // namespace
}  // namespace estancia
