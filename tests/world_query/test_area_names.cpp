// What areas are called: by people, else by a room classifier, else by their words.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/world_file/area_names.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "estancia/map_file/sqlite.hpp"
#include "estancia/session/session.hpp"
#include "estancia/words/installed_words.hpp"
#include "estancia/words/wordnet.hpp"
#include "estancia/world_file/edit_rules.hpp"
#include "estancia/world_query/ask_world.hpp"
#include "estancia/world_query/driven_way.hpp"
#include "estancia/world_query/route_world.hpp"
#include "estancia/world_query/world_json.hpp"
#include "support/errors.hpp"
#include "support/sample_world.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using testing::ElementsAre;
using testing::IsEmpty;

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

}  // namespace
}  // namespace estancia
