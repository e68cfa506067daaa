// Objects, areas and places that words mean, and what areas are called.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "estancia/map_file/places.hpp"
#include "estancia/map_file/sqlite.hpp"
#include "estancia/session/session.hpp"
#include "estancia/words/installed_words.hpp"
#include "estancia/words/wordnet.hpp"
#include "estancia/world_file/area_names.hpp"
#include "estancia/world_file/edit_rules.hpp"
#include "estancia/world_query/ask_world.hpp"
#include "estancia/world_query/driven_way.hpp"
#include "estancia/world_query/route_world.hpp"
#include "estancia/world_query/world_json.hpp"
#include "support/errors.hpp"
#include "support/sample_world.hpp"
#include "support/shape_drive.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using test::FailsWith;
using test::sampleWorld;
using test::ScratchFolder;
using test::ShapeDrive;
using testing::ElementsAre;
using testing::IsEmpty;

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
  world.objects[1].known = KnownPose{"umbrella", 0.6, {}};
  EXPECT_THAT(objectsOf(askWorld(world, "umbrella")), ElementsAre(0, 1, 3, 2)) << "recognized before words";
  EXPECT_DOUBLE_EQ(askWorld(world, "umbrella").objects[1].probability, 0.6);
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
  EXPECT_THAT([&] { askWorld(world, ""); }, FailsWith(ErrorCode::noAnswer));
  EXPECT_THAT([&] { askWorld(world, "umbrela"); }, FailsWith(ErrorCode::noAnswer));
  EXPECT_THAT([&] { askWorld(world, "coridor"); }, FailsWith(ErrorCode::noAnswer, "corridor"))
      << "it suggests given names";
}

class AreaNames : public testing::Test {
 protected:
  /// The sample world with these names by people, and a classifier that gives each area's frames to
  /// "kitchen" with that probability, and the rest to "bathroom".
  WorldMap worldOf(const std::vector<std::string>& given, const std::vector<float>& kitchen) {
    WorldMap world = test::sampleWorld();
    world.edits.clear();
    for (const WorldArea& area : world.areas)
      if (const std::string& name = given[static_cast<std::size_t>(area.id)]; !name.empty())
        world.edits.push_back({AreaEdit::Kind::name, area.center, {}, name});
    std::filesystem::remove(map_);
    test::writeWorld(world, map_);
    RoomPredictions predictions{"test", {"kitchen", "bathroom"}, DescriptorMatrix(2)};
    for (const int area : world.areaOfFrame) {
      const float share = kitchen[static_cast<std::size_t>(area)];
      predictions.probabilities.append(std::vector<float>{share, 1 - share});
    }
    writeRoomPredictions(predictions, map_);
    return readWorld(map_);
  }

  test::ScratchFolder scratch_;
  const std::filesystem::path map_ = scratch_ / "home.estancia";
};

TEST_F(AreaNames, AreThoseOfPeopleThenOfRoomsThenOfWords) {
  const WorldMap world = worldOf({"music room", "", "", ""}, {0.9F, 0.8F, 0.1F, 0.5F});
  EXPECT_EQ(world.areas[0].displayName(), "music room");
  EXPECT_EQ(world.areas[0].predictedRoom, "kitchen");
  EXPECT_NEAR(world.areas[0].roomProbability, 0.9, 1e-6);
  EXPECT_EQ(world.areas[1].displayName(), "kitchen 2") << "as before the first one was called a music room";
  EXPECT_EQ(world.areas[2].displayName(), "bathroom");
  EXPECT_EQ(world.areas[3].displayName(), "umbrella, cup") << "no room is more probable than the others";
  EXPECT_EQ(toJson(world.areas[1])["predicted_room"], "kitchen");
  EXPECT_EQ(areaReference(world, 1)["name"], "kitchen 2");
  EXPECT_TRUE(toJson(test::sampleWorld().areas[1])["room_probability"].is_null());
}

TEST_F(AreaNames, ByNameAloneNeedLessAndMayBeSaidToOccur) {
  WorldMap world = worldOf({"", "", "", ""}, {0.9F, 0.9F, 0.9F, 0.9F});
  RoomPredictions predictions{"test", {"kitchen", "bathroom", "study", "hall"}, DescriptorMatrix(4)};
  for (const int area : world.areaOfFrame)  // sure, less so, hardly, not the best one anywhere
    predictions.probabilities.append(area == 0   ? std::vector<float>{0.7F, 0.1F, 0.1F, 0.1F}
                                     : area == 1 ? std::vector<float>{0.2F, 0.4F, 0.2F, 0.2F}
                                     : area == 2 ? std::vector<float>{0.2F, 0.2F, 0.32F, 0.28F}
                                                 : std::vector<float>{0.28F, 0.24F, 0.24F, 0.24F});
  const auto namesWith = [&](bool byName, bool listed) {
    predictions.areByName = byName;
    predictions.areListed = listed;
    predictions.prior = byName ? std::vector<double>(4, 0.25) : std::vector<double>();
    writeRoomPredictions(predictions, map_);
    const WorldMap read = readWorld(map_);
    EXPECT_EQ(read.places.predictions->prior, predictions.prior);
    std::vector<std::string> names;
    for (const WorldArea& area : read.areas) names.push_back(area.roomName);
    return names;
  };
  EXPECT_THAT(namesWith(false, false), ElementsAre("kitchen", "", "", "")) << "a trained classifier";
  EXPECT_THAT(namesWith(true, false), ElementsAre("kitchen", "bathroom", "", ""));
  EXPECT_THAT(namesWith(true, true), ElementsAre("kitchen", "bathroom", "study", ""))
      << "the study has to be somewhere; the kitchen is elsewhere";
  EXPECT_EQ(readWorld(map_).areas[1].describedName(), "bathroom: " + readWorld(map_).areas[1].name);

  // The second bathroom is sure; the hall is no more probable anywhere than by chance.
  predictions.probabilities = DescriptorMatrix(4);
  for (const int area : world.areaOfFrame)
    predictions.probabilities.append(area == 0   ? std::vector<float>{0.26F, 0.27F, 0.24F, 0.23F}
                                     : area == 1 ? std::vector<float>{0.2F, 0.6F, 0.1F, 0.1F}
                                     : area == 2 ? std::vector<float>{0.3F, 0.5F, 0.1F, 0.1F}
                                                 : std::vector<float>{0.1F, 0.1F, 0.7F, 0.1F});
  EXPECT_THAT(namesWith(true, true), ElementsAre("kitchen", "bathroom 1", "bathroom 2", "study"));
  EXPECT_NEAR(readWorld(map_).areas[0].roomProbability, 0.26, 0.01);
}

TEST_F(AreaNames, TellAreasOfOneRoomApart) {
  const WorldMap world = worldOf({"", "", "", ""}, {0.9F, 0.1F, 0.8F, 0.2F});
  EXPECT_THAT(areasNamed(world, "kitchen"), ElementsAre(0, 2));
  EXPECT_THAT(areasNamed(world, "kitchen 2"), ElementsAre(2));
  EXPECT_THAT(findMeaning(world, "Bathroom").areas, ElementsAre(1, 3));
  EXPECT_EQ(getArea(world, "kitchen 2").id, 2);
  EXPECT_THAT([&] { getArea(world, "kitchen"); }, FailsWith(ErrorCode::unknownName));
  EXPECT_EQ(routeInWorld(world, 3, "kitchen 1").area, 0);
  EXPECT_EQ(routeInWorld(world, 0, "bathroom").area, 1) << "the nearer one";
  const RegionCosts costs = regionCosts(world, {.avoid = {"bathroom"}}, {});
  EXPECT_GT(costs.at(0, 1), 1);
  EXPECT_GT(costs.at(0, 3), 1) << "all bathrooms";
  EXPECT_EQ(costs.at(0, 0), 1);
}

TEST_F(AreaNames, AreFoundInOtherWords) {
  const WorldMap world = worldOf({"", "", "", "Ana's study"}, {0.9F, 0.1F, 0.1F, 0.5F});
  const auto meant = [&](const std::string& words) { return findMeaning(world, words, installedWordGraph); };
  for (const char* words : {"kichen", "the kitchen", "kitchenette"}) {
    EXPECT_THAT(meant(words).areas, ElementsAre(0)) << words;
    EXPECT_THAT(meant(words).rooms, ElementsAre("kitchen")) << words;
    EXPECT_TRUE(meant(words).isWholeName) << words;
  }
  EXPECT_EQ(meant("kichen").corrected, "kitchen");
  EXPECT_EQ(meant("kitchenette").corrected, "");
  EXPECT_THAT(meant("bath room").areas, ElementsAre(1, 2));
  EXPECT_THAT(meant("Anas study").areas, ElementsAre(3)) << "given by people";
  EXPECT_THAT(findMeaning(world, "kichen").areas, IsEmpty()) << "without WordNet it may be a word";
  EXPECT_EQ(routeInWorld(world, 3, "kichen", {}, {}, installedWordGraph).area, 0);
  EXPECT_GT(regionCosts(world, {.avoid = {"kichen"}}, {}, installedWordGraph).at(0, 0), 1);
}

TEST_F(AreaNames, LeaveTheNamesOfPeopleToTheirAreas) {
  const auto taken = worldOf({"", "", "", "Kitchen 2"}, {0.9F, 0.9F, 0.9F, 0.5F}).areas;
  EXPECT_EQ(taken[0].displayName(), "kitchen 1");
  EXPECT_EQ(taken[1].displayName(), "kitchen 4");
  EXPECT_EQ(taken[2].displayName(), "kitchen 3") << "its own number, whatever others are called";
  const WorldMap world = worldOf({"", "kitchen", "", "office"}, {0.9F, 0.1F, 0.3F, 0.9F});
  EXPECT_EQ(world.areas[0].displayName(), "kitchen 1");
  EXPECT_EQ(world.areas[1].displayName(), "kitchen");
  EXPECT_EQ(world.areas[2].displayName(), "bathroom 2");
  EXPECT_EQ(world.areas[3].displayName(), "office");
  EXPECT_THAT(areasNamed(world, "kitchen"), ElementsAre(1));
  EXPECT_THAT(areasNamed(world, "bathtub"), IsEmpty()) << "these are words";
  EXPECT_THAT(areasCalled(world, "bathtub"), ElementsAre(1));
}

TEST_F(AreaNames, AreFoundByTheirWords) {
  const WorldMap world = worldOf({"music  room, upstairs", "", "", ""}, {0.5F, 0.9F, 0.8F, 0.5F});
  for (const char* part : {"music", "Music Room", "upstairs", "rooms"}) {
    const WorldMeaning meaning = findMeaning(world, part);
    EXPECT_THAT(meaning.areas, ElementsAre(0)) << part;
    EXPECT_FALSE(meaning.isWholeName);
    EXPECT_EQ(routeInWorld(world, 3, part).area, 0);
  }
  EXPECT_TRUE(findMeaning(world, "music room upstairs").isWholeName);
  EXPECT_THAT(findMeaning(world, "2").areas, ElementsAre(2)) << "kitchen 2";
  EXPECT_THAT(areasNamedPartly(world, "mus"), IsEmpty());
  EXPECT_THAT(areasNamedPartly(world, ""), IsEmpty());
  const WorldMap clash = worldOf({"umbrella room", "", "", ""}, {0.5F, 0.5F, 0.5F, 0.5F});
  EXPECT_TRUE(routeInWorld(clash, 0, "umbrella").object) << "a thing before a part of a name";
}

class ShapeClasses : public testing::Test {
 protected:
  WorldMap map(const test::Shape& shape, std::size_t end = 12, const std::string& digest = "one") const {
    return test::mapShapes(ShapeDrive(shape), end, file_, [&](WorldMapper& world) {
      if (!digest.empty()) world.classify(model_, digest);
    });
  }
  std::int64_t number(const std::string& sql) const {
    return sqlite::Database(file_, sqlite::Database::Mode::read).number(sql);
  }

  const ObjectModel model_ = test::modelOfShapes();
  ScratchFolder scratch_;
  const fs::path file_ = scratch_ / "map.estancia";
};

/// The probabilities of the only object's classes.
std::map<std::string, float> classesOf(const WorldMap& world) {
  std::map<std::string, float> classes;
  EXPECT_EQ(world.objects.size(), 1U);
  for (const LabelProbability& of : world.objects.at(0).shapeClasses) classes[of.label] = of.probability;
  return classes;
}

TEST_F(ShapeClasses, AreThoseOfTheBestViewsPooled) {
  const WorldMap desk = map(test::desk);
  const auto classes = classesOf(desk);
  ASSERT_EQ(classes.size(), 2U);
  EXPECT_GT(classes.at("desk"), 0.6F);
  EXPECT_NEAR(classes.at("desk") + classes.at("shelf"), 1, 1e-5);
  EXPECT_EQ(number("SELECT count(*) FROM segment_shapes"), 5) << "the work of an object is bounded";
  fs::remove(file_);
  EXPECT_GT(classesOf(map(test::shelf)).at("shelf"), 0.6F);
}

TEST_F(ShapeClasses, AreAskedForAndTold) {
  const WorldMap world = map(test::desk);
  const WorldObject& object = world.objects.at(0);
  EXPECT_NE(object.displayName(), "desk") << "the labeler's words stay";
  const WorldAnswers answers = askWorld(world, "Desks");
  ASSERT_EQ(answers.objects.size(), 1U);
  EXPECT_TRUE(answers.objects[0].isShaped);
  EXPECT_TRUE(answers.objects[0].isLikely());
  EXPECT_NEAR(answers.objects[0].probability, classesOf(world).at("desk"), 1e-6);
  EXPECT_THAT([&] { askWorld(world, "shelf"); }, FailsWith(ErrorCode::noAnswer)) << "improbable";
  EXPECT_THAT(findNearNames(world, "desc"), testing::Contains("desk"));
  const auto json = toJson("desk", answers, world)["objects"][0];
  EXPECT_EQ(json["by_shape"], true);
  EXPECT_EQ(json["shape"]["class"], "desk");
  EXPECT_EQ(json["shape"]["classes"].size(), 2U);
}

TEST_F(ShapeClasses, StayAndMayBeGivenAfterTheDrive) {
  EXPECT_TRUE(classesOf(map(test::desk, 8, "")).empty());
  const auto early = classesOf(map(test::desk, 8));
  EXPECT_GT(early.at("desk"), 0.6F);
  EXPECT_GT(classesOf(map(test::desk, 12, "")).at("desk"), 0.6F) << "without the model";
  const auto continued = classesOf(map(test::desk, 12));
  fs::remove(file_);
  EXPECT_EQ(classesOf(map(test::desk, 12)), continued) << "as in one run";
  sqlite::Database(file_, sqlite::Database::Mode::write).run("UPDATE segment_shapes SET probabilities = x''");
  EXPECT_TRUE(classesOf(map(test::desk, 12)).empty()) << "what the model said is not asked again";
  EXPECT_FALSE(classesOf(map(test::desk, 12, "another")).empty()) << "another model is";
}

}  // namespace
}  // namespace estancia
