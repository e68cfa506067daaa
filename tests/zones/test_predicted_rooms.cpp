// Rooms that a classifier has named: of zones, in their file, and for other programs.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>

#include "estancia/zones/zone_file.hpp"
#include "estancia/zones/zone_names.hpp"
#include "estancia/zones/zones_json.hpp"
#include "recordings.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using nlohmann::ordered_json;
using test::FailsWith;
using testing::IsEmpty;

/// Zones of 12, 8 and 4 images; the first two are taken for a kitchen, of the last nothing was said.
Zones namedZones(bool truth = false) {
  DescriptorSequence recording = test::driveThrough({0, 0, 0, 1, 1, 2}, 4);
  std::vector<int> groups;
  RoomPredictions said{"forest on test", {"bath", "kitchen"}, DescriptorMatrix(2)};
  for (std::size_t i = 0; i < recording.frames.size(); ++i) {
    groups.push_back(i < 12 ? 0 : i < 20 ? 1 : 2);
    said.probabilities.append(i < 12   ? std::vector<float>{0.125F, 0.875F}
                              : i < 20 ? std::vector<float>{0.375F, 0.625F}
                                       : std::vector<float>{0, 0});
    if (!truth) recording.frames[i].room.clear();
  }
  Zones zones = describeZones(recording, groups);
  nameRooms(zones, said);
  return zones;
}

TEST(PredictedRoomsOfZones, ArePooledOverTheirImages) {
  const Zones zones = namedZones();
  EXPECT_EQ(zones.zones[0].predicted.front(), (RoomProbability{"kitchen", 0.875}));
  EXPECT_EQ(zones.zones[1].predicted.back(), (RoomProbability{"bath", 0.375}));
  EXPECT_THAT(zones.zones[2].predicted, IsEmpty());
  EXPECT_EQ(zones.zones[0].room, "") << "what is predicted is never the truth";
  EXPECT_EQ(namedZones(true).zones[0].room, "room 0");
  Zones other = namedZones();
  const RoomPredictions few{"x", {"a"}, DescriptorMatrix(1)};
  EXPECT_THAT([&] { nameRooms(other, few); }, FailsWith(ErrorCode::mismatch, "0 frames", "24 frames"));
}

TEST(PredictedRoomsOfZones, ByNameAloneAreThoseThatAreSure) {
  Zones zones = namedZones();
  RoomPredictions said{"by name", {"bath", "kitchen", "shop"}, DescriptorMatrix(3)};
  said.areByName = true;
  for (std::size_t i = 0; i < zones.frames.size(); ++i) {
    said.probabilities.append(i < 20 ? std::vector<float>{0.1F, 0.8F, 0.1F}
                                     : std::vector<float>{0.33F, 0.33F, 0.33F});
    said.evidence.push_back(
        {i, i < 12 ? 0 : i % 2, {0, 3, 0}});  // one label, or two, half of the images each
  }
  nameRooms(zones, said);
  EXPECT_THAT(zones.zones[0].predicted, IsEmpty()) << "one label";
  EXPECT_EQ(zones.zones[1].predicted.front().room, "kitchen");
  EXPECT_THAT(zones.zones[2].predicted, IsEmpty()) << "no room is probable";
  EXPECT_EQ(zones.classifier, "") << "none has named them";
  EXPECT_EQ(describedName(zones.zones[1]), "kitchen: " + zones.zones[1].name);
  EXPECT_EQ(shortName(zones.zones[1]), "kitchen");
  EXPECT_EQ(describedName(zones.zones[0]), zones.zones[0].name);
  EXPECT_EQ(shortName(zones.zones[0]) + ",",
            zones.zones[0].name.substr(0, zones.zones[0].name.find(',') + 1));
  const ordered_json rooms = ordered_json::parse(toRoomsJson(zones, 3));
  EXPECT_EQ(rooms.size(), 3U) << "the kitchen, and two zones by their words";
  EXPECT_TRUE(rooms.contains("kitchen"));
}

TEST(PredictedRoomsOfZones, AreKeptInTheFile) {
  const test::ScratchFolder folder;
  const Zones zones = namedZones();
  writeZones(zones, folder / "home.zones");
  const Zones back = readZones(folder / "home.zones");
  EXPECT_EQ(back.classifier, "forest on test");
  for (std::size_t i = 0; i < zones.zones.size(); ++i)
    EXPECT_EQ(back.zones[i].predicted, zones.zones[i].predicted);
  Zones plain = zones;
  plain.classifier.clear();
  for (Zone& zone : plain.zones) zone.predicted.clear();
  EXPECT_FALSE(ordered_json::parse(zoneFileText(plain))["zones"][0].contains("predicted"));
}

TEST(PredictedRoomsOfZones, AreNotBelievedWhereTheyCannotBe) {
  const test::ScratchFolder folder;
  const auto refusal = [&](const char* pointer, const ordered_json& value) {
    ordered_json json = ordered_json::parse(zoneFileText(namedZones()));
    json[ordered_json::json_pointer(pointer)] = value;
    test::writeFile(folder / "changed.zones", json.dump());
    return test::caught([&] { readZones(folder / "changed.zones"); });
  };
  EXPECT_THAT(refusal("/zones/0/predicted/0/p", 2), FailsWith(ErrorCode::corruptFile, "changed.zones", "2"));
  EXPECT_THAT(refusal("/zones/0/predicted/0/p", "x"), FailsWith(ErrorCode::corruptFile, "changed.zones"));
  EXPECT_THAT(refusal("/zones/0/predicted/0/room", 3), FailsWith(ErrorCode::corruptFile, "changed.zones"));
  EXPECT_THAT(refusal("/zones/0/predicted", 3), FailsWith(ErrorCode::corruptFile, "changed.zones"));
  EXPECT_THAT(refusal("/classifier", 3), FailsWith(ErrorCode::corruptFile, "changed.zones"));
}

TEST(PredictedRoomsOfZones, AreRoomsForOtherProgramsWhereTheTruthIsUnknown) {
  const ordered_json rooms = ordered_json::parse(toRoomsJson(namedZones(), 3));
  ASSERT_EQ(rooms.size(), 1U);
  EXPECT_EQ(rooms["kitchen"]["images"], 20);
  EXPECT_EQ(rooms["kitchen"]["predicted"], 0.775) << "(12 · 0.875 + 8 · 0.625) / 20";
  EXPECT_EQ(rooms["kitchen"]["zones"], (ordered_json{0, 1}));
  EXPECT_EQ(rooms["kitchen"]["words"].size(), 3U);
  EXPECT_TRUE(ordered_json::parse(toRoomsJson(namedZones(true))).contains("room 0"));
}

TEST(ZonesJson, HasTheFamiliarWordBesideTheLabel) {
  const Zones zones = namedZones();
  std::vector<std::size_t> labels(zones.vocabulary.size());
  std::iota(labels.begin(), labels.end(), std::size_t{0});
  const LabelConcepts concepts{{"thing", 1, labels, labels}};
  const ordered_json json = toJson(zones, 3, concepts), plain = toJson(zones, 3);
  EXPECT_EQ(json["zones"][0]["words"][0]["word"], "thing");
  EXPECT_EQ(json["zones"][0]["words"][0]["label"], plain["zones"][0]["words"][0]["label"]);
  EXPECT_EQ(json["zones"][0]["words"][0]["p"], plain["zones"][0]["words"][0]["p"]);
}

TEST(ZonesJson, TellsZonesAndWhatIsNotKnown) {
  const Zones zones = namedZones();
  const ordered_json json = toJson(zones, 3);
  EXPECT_EQ(json["model"], "test");
  ASSERT_EQ(json["zones"].size(), 3U);
  const ordered_json& first = json["zones"][0];
  EXPECT_EQ(first["images"], 12);
  EXPECT_EQ(first["share"], 0.5);
  EXPECT_EQ(first["words"].size(), 3U);
  EXPECT_EQ(first["words"][0]["p"].get<float>(),
            zones.zones[0].mean[static_cast<std::size_t>(
                std::ranges::find(zones.vocabulary.labels(), first["words"][0]["label"].get<std::string>()) -
                zones.vocabulary.labels().begin())]);
  EXPECT_TRUE(first["room"].is_null());
  EXPECT_TRUE(first["position"].is_null());
  EXPECT_EQ(first["predicted_rooms"][0], (ordered_json{{"room", "kitchen"}, {"p", 0.875}}));
  EXPECT_FALSE(json["zones"][2].contains("predicted_rooms"));
  EXPECT_EQ(json["rooms"], ordered_json::parse(toRoomsJson(zones)));
  EXPECT_EQ(first["words"][0]["word"], first["words"][0]["label"]);
  EXPECT_EQ(toJson(namedZones(true))["zones"][0]["room_share"], 1.0);
}

}  // namespace
}  // namespace estancia
