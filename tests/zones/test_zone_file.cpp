// The zone file goes out and comes back, else it is refused; rooms that a classifier has named.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/zones/zones.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "estancia/zones/naming.hpp"
#include "recordings.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using nlohmann::ordered_json;
using test::FailsWith;
using test::readFile;
using test::writeFile;
using testing::IsEmpty;

Zones someZones() {
  DescriptorSequence recording = test::driveThrough({0, 1, 2}, 8);
  recording.frames[3].name = "odd \"name\"";
  recording.frames[3].room = "";
  recording.frames[4].timestamp = 1321.123456789;
  recording.frames[4].pose = Pose{0.1, -2e-7, 3, 0.1, 0.2, 0.3, 0.927};
  return findZones(recording);
}

class ZoneFile : public testing::Test {
 protected:
  void SetUp() override { writeZones(zones_, file_); }

  /// What reading the file throws after one change.
  test::Caught refusal(const std::function<void(ordered_json&)>& change) {
    ordered_json json = ordered_json::parse(readFile(file_));
    change(json);
    writeFile(scratch_ / "changed.zones", json.dump());
    return test::caught([&] { readZones(scratch_ / "changed.zones"); });
  }

  test::ScratchFolder scratch_;
  const std::string file_ = scratch_ / "home.zones";
  const Zones zones_ = someZones();
};

TEST_F(ZoneFile, ComesBackAsItWas) {
  const Zones back = readZones(file_);
  EXPECT_EQ(back.vocabulary, zones_.vocabulary);
  EXPECT_EQ(back.distance, zones_.distance);
  EXPECT_EQ(back.linkage, zones_.linkage);
  EXPECT_EQ(back.cut, zones_.cut);
  EXPECT_EQ(back.zoneOf, zones_.zoneOf);
  ASSERT_EQ(back.frames.size(), zones_.frames.size());
  EXPECT_EQ(back.frames[3].name, zones_.frames[3].name) << "to the byte";
  EXPECT_EQ(back.frames[4].timestamp, zones_.frames[4].timestamp);
  EXPECT_EQ(back.frames[4].pose.value().y, -2e-7);
  EXPECT_EQ(back.frames[4].pose.value().qw, 0.927);
  ASSERT_EQ(back.zones.size(), zones_.zones.size());
  for (std::size_t i = 0; i < back.zones.size(); ++i) {
    const Zone &a = back.zones[i], &b = zones_.zones[i];
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.images, b.images);
    EXPECT_EQ(a.mean, b.mean) << "the same float32";
    EXPECT_EQ(a.sigma, b.sigma);
    EXPECT_EQ(a.room, b.room);
  }
  ASSERT_EQ(back.rooms.size(), 3U);
  EXPECT_EQ(back.rooms[2].mean, zones_.rooms[2].mean);
  EXPECT_EQ(back.dendrogram.value().cutInto(5), zones_.dendrogram.value().cutInto(5));
  EXPECT_EQ(zoneFileText(back), readFile(file_));
}

TEST_F(ZoneFile, TextsOfOthersAreReadWithoutControlCharacters) {
  DescriptorSequence recording = test::recordingOf({{1, 0, 0.5F}});
  recording.vocabulary = Vocabulary({"a\x1B[2J", "caf\xE9", "c"}, {{2, 1}, {1, 0.3F}});
  recording.model = "m\x1B";
  recording.frames[0].name = "f\x1B";
  Zones zones = describeZones(recording, std::vector<int>{0});
  zones.zones[0].name = "z\x1B";
  zones.zones[0].predicted = {{"p\x1B", 1}};
  writeZones(zones, file_);
  const Zones back = readZones(file_);
  EXPECT_THAT(back.vocabulary.labels(), testing::ElementsAre("a\\x1B[2J", "caf\\xE9", "c"));
  EXPECT_EQ(back.vocabulary.layout().parts, recording.vocabulary.layout().parts);
  EXPECT_EQ(back.model, "m\\x1B");
  EXPECT_EQ(back.frames[0].name, "f\\x1B");
  EXPECT_EQ(back.zones[0].name, "z\\x1B");
  EXPECT_EQ(back.zones[0].predicted[0].room, "p\\x1B");
}

TEST_F(ZoneFile, IsKnownByItsBeginning) {
  EXPECT_TRUE(isZoneFile(file_));
  for (const char* space : {"", " ", "\t", "\r\n"}) {
    writeFile(scratch_ / "spaced", space + ordered_json::parse(readFile(file_)).dump(*space == 0 ? -1 : 2));
    EXPECT_TRUE(isZoneFile(scratch_ / "spaced"));
  }
  writeFile(scratch_ / "other", "{\"format\": \"estancia-places\"}");
  EXPECT_FALSE(isZoneFile(scratch_ / "other"));
  EXPECT_FALSE(isZoneFile(scratch_.path()));
  EXPECT_FALSE(isZoneFile(scratch_ / "missing"));
}

TEST_F(ZoneFile, IsRefusedWhenItIsNone) {
  EXPECT_THAT([&] { readZones(scratch_ / "missing"); }, FailsWith(ErrorCode::fileNotFound));
  EXPECT_THAT([&] { readZones(scratch_.path()); }, FailsWith(ErrorCode::fileUnreadable));
  EXPECT_THAT([&] { writeZones(zones_, scratch_ / "none/home.zones"); },
              FailsWith(ErrorCode::fileUnwritable));
  for (const char* text : {"hello", ""}) {
    writeFile(scratch_ / "text", text);
    EXPECT_THAT([&] { readZones(scratch_ / "text"); }, FailsWith(ErrorCode::unsupportedFile)) << text;
  }
  for (const int version : {1, 4})
    EXPECT_THAT(refusal([&](ordered_json& json) { json["version"] = version; }),
                FailsWith(ErrorCode::unsupportedFile, "version " + std::to_string(version), "version 3"));
}

TEST_F(ZoneFile, IsRefusedWhenItIsDamaged) {
  const std::vector<std::pair<std::string, ordered_json>> changes{
      {"/version", "one"},
      {"/vocabulary/digest", "00"},
      {"/vocabulary/labels/0", ""},
      {"/vocabulary/labels/0", {{"hex", "zz"}}},
      {"/vocabulary/labels", ordered_json::array()},
      {"/vocabulary/parts/0/size", 18446744073709551615U},
      {"/vocabulary/parts/0/weight", -1},
      {"/settings/cut", "auto"},
      {"/zones", nullptr},
      {"/zones/0/id", 1},
      {"/zones/0/images", 9999999},
      {"/zones/0/mean", {0.5}},
      {"/zones/0/mean", 1},
      {"/zones/0/mean/3", 7},
      {"/zones/0/sigma/3", -0.5},
      {"/zones/0/extent", {{"center", {1, 2}}, {"spread", 1}, {"images", 1}}},
      {"/zones/0/extent", {{"center", 1}, {"spread", 1}, {"images", 1}}},
      {"/zones/0/extent", {{"center", {1, 2, 3}}, {"spread", 1}, {"images", 99}}},
      {"/zones/0/predicted", {{{"room", "bath"}, {"p", 2}}}},
      {"/zones/0/predicted", {{{"room", "bath"}, {"p", -1}}}},
      {"/zones/0/images", ordered_json::array()},
      {"/rooms/0/images", 1000},
      {"/rooms/0/mean", ordered_json::array()},
      {"/frames", ordered_json::array()},
      {"/frames/0/zone", 3},
      {"/frames/0/zone", 0.5},
      {"/frames/0/timestamp", "noon"},
      {"/frames/4/pose", {1, 2, 3}},
      {"/dendrogram", ordered_json::array()},
      {"/dendrogram/0", {0, 1, 2}},
      {"/dendrogram/0", 7},
      {"/dendrogram/0/0", 47},
      {"/dendrogram/0/2", -1},
      {"/dendrogram/0/3", 25}};
  for (const auto& [at, value] : changes)
    EXPECT_THAT(refusal([&, where = at, what = value](ordered_json& json) {
                  json[ordered_json::json_pointer(where)] = what;
                }),
                FailsWith(ErrorCode::corruptFile))
        << at << " = " << value;
  for (const char* key : {"version", "vocabulary", "model", "settings", "zones", "rooms", "frames"})
    EXPECT_THAT(refusal([&](ordered_json& json) { json.erase(key); }), FailsWith(ErrorCode::corruptFile));
}

TEST_F(ZoneFile, IsRefusedWhenNumbersAreNoneOrItIsCutOffOrNestedTooDeeply) {
  const std::string whole = readFile(file_);
  for (const char* number : {"NaN", "1e999"}) {
    std::string text = whole;
    const std::size_t at = text.find("\"cut\":") + 6;
    text.replace(at, text.find(',', at) - at, number);
    writeFile(scratch_ / "odd.zones", text);
    EXPECT_THAT([&] { readZones(scratch_ / "odd.zones"); }, FailsWith(ErrorCode::corruptFile)) << number;
  }
  writeFile(scratch_ / "cut.zones", whole.substr(0, whole.size() / 2));
  EXPECT_THAT([&] { readZones(scratch_ / "cut.zones"); }, FailsWith(ErrorCode::corruptFile));
  writeFile(scratch_ / "deep.zones",
            "{\"format\": \"estancia-zones\", \"version\": " + std::string(100'000, '['));
  EXPECT_THAT([&] { readZones(scratch_ / "deep.zones"); }, FailsWith(ErrorCode::corruptFile));
}

/// Zones of 12, 8 and 4 images; the first two are taken for a kitchen, the last has no prediction.
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
  EXPECT_THAT([&] { nameRooms(other, few); }, FailsWith(ErrorCode::mismatch));
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

TEST(PredictedRoomsOfZones, AreRoomsForOtherProgramsWhereTheTruthIsUnknown) {
  const ordered_json rooms = ordered_json::parse(toRoomsJson(namedZones(), 3));
  ASSERT_EQ(rooms.size(), 1U);
  EXPECT_EQ(rooms["kitchen"]["images"], 20);
  EXPECT_EQ(rooms["kitchen"]["predicted"], 0.775) << "(12 · 0.875 + 8 · 0.625) / 20";
  EXPECT_EQ(rooms["kitchen"]["zones"], (ordered_json{0, 1}));
  EXPECT_EQ(rooms["kitchen"]["words"].size(), 3U);
  EXPECT_TRUE(ordered_json::parse(toRoomsJson(namedZones(true))).contains("room 0"));
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
