// Rooms that a classifier has named: of zones, in their file, and for other programs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "estancia/zones/rooms.hpp"
#include "estancia/zones/zone_file.hpp"
#include "recordings.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using nlohmann::ordered_json;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

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
  EXPECT_THAT(test::errorOf([&] { nameRooms(other, few); }), HasSubstr("rooms of 0 images were predicted"));
}

TEST(PredictedRoomsOfZones, AreKeptInTheFile) {
  const test::ScratchFolder folder;
  const Zones zones = namedZones();
  writeZoneFile(zones, folder / "home.zones");
  const Zones back = readZoneFile(folder / "home.zones");
  EXPECT_EQ(back.classifier, "forest on test");
  for (std::size_t i = 0; i < zones.zones.size(); ++i)
    EXPECT_EQ(back.zones[i].predicted, zones.zones[i].predicted);
  EXPECT_EQ(ordered_json::parse(zoneFileText(zones))["version"], 2);
  Zones plain = zones;
  plain.classifier.clear();
  for (Zone& zone : plain.zones) zone.predicted.clear();
  EXPECT_EQ(ordered_json::parse(zoneFileText(plain))["version"], 1) << "older programs read it";
  EXPECT_THAT(zoneFileText(plain), Not(HasSubstr("predicted")));
}

TEST(PredictedRoomsOfZones, AreNotBelievedWhereTheyCannotBe) {
  const test::ScratchFolder folder;
  const auto complaint = [&](const char* pointer, const ordered_json& value) {
    ordered_json json = ordered_json::parse(zoneFileText(namedZones()));
    json[ordered_json::json_pointer(pointer)] = value;
    test::writeFile(folder / "changed.zones", json.dump());
    return test::errorOf([&] { readZoneFile(folder / "changed.zones"); });
  };
  EXPECT_THAT(complaint("/zones/0/predicted/0/p", 2), HasSubstr("predicted room is 2"));
  EXPECT_THAT(complaint("/zones/0/predicted/0/p", "x"), HasSubstr("damaged"));
  EXPECT_THAT(complaint("/zones/0/predicted/0/room", 3), HasSubstr("damaged"));
  EXPECT_THAT(complaint("/zones/0/predicted", 3), HasSubstr("damaged"));
  EXPECT_THAT(complaint("/classifier", 3), HasSubstr("damaged"));
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

}  // namespace
}  // namespace estancia
