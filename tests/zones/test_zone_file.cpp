// The zone file goes out and comes back, and whatever else is given is refused with a sentence.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/zones/zone_file.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <nlohmann/json.hpp>
#include <random>

#include "estancia/zones/zones_json.hpp"
#include "recordings.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using nlohmann::ordered_json;
using test::FailsWith;
using test::readFile;
using test::writeFile;

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
  EXPECT_EQ(back.model, zones_.model);
  EXPECT_EQ(back.distance, zones_.distance);
  EXPECT_EQ(back.linkage, zones_.linkage);
  EXPECT_EQ(back.cut, zones_.cut);
  EXPECT_EQ(back.cutReason, zones_.cutReason);
  EXPECT_EQ(back.zoneOf, zones_.zoneOf);
  ASSERT_EQ(back.frames.size(), zones_.frames.size());
  for (std::size_t i = 0; i < back.frames.size(); ++i) {
    EXPECT_EQ(back.frames[i].name, zones_.frames[i].name) << "to the byte, UTF-8 or not";
    EXPECT_EQ(back.frames[i].room, zones_.frames[i].room);
    EXPECT_EQ(back.frames[i].timestamp, zones_.frames[i].timestamp);
    EXPECT_EQ(back.frames[i].pose.has_value(), zones_.frames[i].pose.has_value());
  }
  EXPECT_EQ(back.frames[4].pose.value().y, -2e-7);
  EXPECT_EQ(back.frames[4].pose.value().qw, 0.927);
  ASSERT_EQ(back.zones.size(), zones_.zones.size());
  for (std::size_t i = 0; i < back.zones.size(); ++i) {
    const Zone &a = back.zones[i], &b = zones_.zones[i];
    EXPECT_EQ(a.id, b.id);
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.images, b.images);
    EXPECT_EQ(a.mean, b.mean) << "the same float32";
    EXPECT_EQ(a.sigma, b.sigma);
    EXPECT_EQ(a.room, b.room);
    EXPECT_EQ(a.roomShare, b.roomShare);
    ASSERT_EQ(a.extent.has_value(), b.extent.has_value());
    if (a.extent) {
      EXPECT_EQ(a.extent->center, b.extent->center);
    }
  }
  ASSERT_EQ(back.rooms.size(), 3U);
  EXPECT_EQ(back.rooms[2].mean, zones_.rooms[2].mean);
  EXPECT_EQ(back.dendrogram.value().cutInto(5), zones_.dendrogram.value().cutInto(5));
  EXPECT_EQ(zoneFileText(back), readFile(file_));
}

TEST_F(ZoneFile, KeepsEveryFloat) {
  std::mt19937 random(1);
  std::vector<std::vector<float>> rows(4);
  for (auto& row : rows)
    while (row.size() < 500) {
      const auto value = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
      if (value >= 0 && value <= 1) row.push_back(value);
    }
  const Zones zones = describeZones(test::recordingOf(rows), std::vector<int>{0, 1, 2, 3});
  writeZones(zones, file_);
  const Zones back = readZones(file_);
  for (std::size_t i = 0; i < rows.size(); ++i) EXPECT_EQ(back.zones[i].mean, rows[i]);
  EXPECT_FALSE(back.dendrogram) << "these were not clustered";
}

TEST_F(ZoneFile, KeepsWhichModelSaysWhat) {
  DescriptorSequence recording = test::recordingOf({{1, 0, 0.5F}});
  recording.vocabulary = Vocabulary({"a", "café", "c"}, {{2, 1}, {1, 0.3F}});
  writeZones(describeZones(recording, std::vector<int>{0}), file_);
  const Zones back = readZones(file_);
  EXPECT_EQ(back.vocabulary, recording.vocabulary);
  EXPECT_EQ(back.vocabulary.layout().parts, recording.vocabulary.layout().parts);
}

TEST_F(ZoneFile, TextsOfOthersAreReadWithoutControlCharacters) {
  DescriptorSequence recording = test::recordingOf({{1, 0, 0.5F}});
  recording.vocabulary = Vocabulary({"a\x1B[2J", "caf\xE9", "c"}, {{2, 1}, {1, 0.3F}});
  recording.model = "m\x1B";
  recording.frames[0].name = "f\x1B";
  recording.frames[0].room = "r\x1B";
  Zones zones = describeZones(recording, std::vector<int>{0});
  zones.zones[0].name = "z\x1B";
  zones.zones[0].predicted = {{"p\x1B", 1}};
  writeZones(zones, file_);
  const Zones back = readZones(file_);
  EXPECT_THAT(back.vocabulary.labels(), testing::ElementsAre("a\\x1B[2J", "caf\\xE9", "c"));
  EXPECT_EQ(back.vocabulary.layout().parts, recording.vocabulary.layout().parts);
  EXPECT_EQ(back.model, "m\\x1B");
  EXPECT_EQ(back.frames[0].name, "f\\x1B");
  EXPECT_EQ(back.frames[0].room, "r\\x1B");
  EXPECT_EQ(back.zones[0].name, "z\\x1B");
  EXPECT_EQ(back.zones[0].room, "r\\x1B");
  EXPECT_EQ(back.zones[0].predicted[0].room, "p\\x1B");
}

TEST_F(ZoneFile, IsKnownByItsBeginning) {
  EXPECT_TRUE(isZoneFile(file_));
  writeFile(scratch_ / "flat", ordered_json::parse(readFile(file_)).dump());
  EXPECT_TRUE(isZoneFile(scratch_ / "flat"));
  writeFile(scratch_ / "other", "{\"format\": \"estancia-places\"}");
  EXPECT_FALSE(isZoneFile(scratch_ / "other"));
  EXPECT_FALSE(isZoneFile(scratch_.path()));
  EXPECT_FALSE(isZoneFile(scratch_ / "missing"));
}

TEST_F(ZoneFile, IsRefusedWhenItIsNone) {
  EXPECT_THAT([&] { readZones(scratch_ / "missing"); }, FailsWith(ErrorCode::fileNotFound, "missing"));
  EXPECT_THAT([&] { readZones(scratch_.path()); }, FailsWith(ErrorCode::fileUnreadable));
  for (const char* text : {"hello", ""}) {
    writeFile(scratch_ / "text", text);
    EXPECT_THAT([&] { readZones(scratch_ / "text"); }, FailsWith(ErrorCode::unsupportedFile, "text")) << text;
  }
  for (const int version : {1, 2, 4})
    EXPECT_THAT(refusal([&](ordered_json& json) { json["version"] = version; }),
                FailsWith(ErrorCode::unsupportedFile, "version " + std::to_string(version), "version 3"));
}

TEST_F(ZoneFile, IsRefusedWhereverItIsCutOff) {
  const std::string whole = readFile(file_);
  for (std::size_t length = 60; length + 2 < whole.size(); length += 97) {
    writeFile(scratch_ / "cut.zones", whole.substr(0, length));
    EXPECT_THAT([&] { readZones(scratch_ / "cut.zones"); }, FailsWith(ErrorCode::corruptFile, "cut.zones"))
        << length;
  }
}

TEST_F(ZoneFile, IsRefusedWhenItIsDamaged) {
  const std::vector<std::pair<std::string, ordered_json>> changes{
      {"/version", "one"},
      {"/version", -1},
      {"/vocabulary/digest", "00"},
      {"/vocabulary/labels", 7},
      {"/vocabulary/labels/0", ""},
      {"/vocabulary/labels/0", {{"hex", "zz"}}},
      {"/vocabulary/labels", ordered_json::array()},
      {"/vocabulary/parts/0/size", 1e300},
      {"/vocabulary/parts/0/size", 18446744073709551615U},
      {"/vocabulary/parts/0/weight", -1},
      {"/model", 3},
      {"/settings", nullptr},
      {"/settings/cut", "auto"},
      {"/zones", nullptr},
      {"/zones/0", 1},
      {"/zones/0/id", 1},
      {"/zones/0/images", 9999999},
      {"/zones/0/mean", {0.5}},
      {"/zones/0/mean/3", 7},
      {"/zones/0/mean/3", nullptr},
      {"/zones/0/sigma/3", -0.5},
      {"/zones/0/room_share", "all"},
      {"/zones/0/extent", {{"center", {1, 2}}, {"spread", 1}, {"images", 1}}},
      {"/zones/0/extent", {{"center", {1, 2, 3}}, {"spread", 1}, {"images", 99}}},
      {"/rooms/0/images", 1000},
      {"/rooms/0/mean", ordered_json::array()},
      {"/frames", ordered_json::array()},
      {"/frames", "none"},
      {"/frames/0/zone", 3},
      {"/frames/0/zone", -1},
      {"/frames/0/zone", 0.5},
      {"/frames/0/zone", 4294967296U},
      {"/frames/0/name", 5},
      {"/frames/0/timestamp", "noon"},
      {"/frames/4/pose", {1, 2, 3}},
      {"/frames/4/pose/0", nullptr},
      {"/dendrogram", 5},
      {"/dendrogram", ordered_json::array()},
      {"/dendrogram/0", {0, 1, 2}},
      {"/dendrogram/0/0", 47},
      {"/dendrogram/0/1", 18446744073709551615U},
      {"/dendrogram/0/2", -1},
      {"/dendrogram/0/3", 25}};
  for (const auto& [at, value] : changes)
    EXPECT_THAT(refusal([&, where = at, what = value](ordered_json& json) {
                  json[ordered_json::json_pointer(where)] = what;
                }),
                FailsWith(ErrorCode::corruptFile, "changed.zones"))
        << at << " = " << value;
  for (const char* key : {"version", "vocabulary", "model", "settings", "zones", "rooms", "frames"})
    EXPECT_THAT(refusal([&](ordered_json& json) { json.erase(key); }),
                FailsWith(ErrorCode::corruptFile, "changed.zones", fmt::format("\"{}\" is missing", key)));
  EXPECT_THAT(refusal([](ordered_json& json) { json["zones"][0] = 5; }),
              FailsWith(ErrorCode::corruptFile, "changed.zones", "another type"));
}

TEST_F(ZoneFile, IsRefusedWhenNumbersAreNone) {
  const std::string whole = readFile(file_);
  for (const char* number : {"NaN", "1e999", "-1e999", "Infinity"}) {
    std::string text = whole;
    const std::size_t at = text.find("\"cut\":") + 6;
    text.replace(at, text.find(',', at) - at, number);
    writeFile(scratch_ / "odd.zones", text);
    EXPECT_THAT([&] { readZones(scratch_ / "odd.zones"); }, FailsWith(ErrorCode::corruptFile, "odd.zones"))
        << number;
  }
  writeFile(scratch_ / "deep.zones",
            "{\"format\": \"estancia-zones\", \"version\": " + std::string(100'000, '['));
  EXPECT_THAT([&] { readZones(scratch_ / "deep.zones"); }, FailsWith(ErrorCode::corruptFile, "8 levels"));
}

TEST_F(ZoneFile, SaysWhenItCannotBeWritten) {
  EXPECT_THAT([&] { writeZones(zones_, scratch_ / "none/home.zones"); },
              FailsWith(ErrorCode::fileUnwritable, "none/home.zones"));
}

TEST(RoomsJson, TellsRoomsWhereTheyAreKnown) {
  DescriptorSequence recording = test::recordingOf({{0.5F, 0.5F, 0}, {0.3F, 0.7F, 0}, {0, 0.4F, 0.6F}});
  recording.frames[0].room = recording.frames[1].room = "kitchen";
  recording.frames[2].room = "bath";
  const auto json = ordered_json::parse(toRoomsJson(describeZones(recording, std::vector<int>{0, 0, 1}), 2));
  ASSERT_EQ(json.size(), 2U);
  EXPECT_EQ(json["bath"]["images"], 1);
  EXPECT_EQ(json["bath"]["words"], (ordered_json{{"word 2", 0.6}, {"word 1", 0.4}}))
      << "most distinctive first";
  EXPECT_EQ(json["kitchen"]["images"], 2);
  EXPECT_EQ(json["kitchen"]["words"], (ordered_json{{"word 0", 0.4}, {"word 1", 0.6}}));
}

TEST(RoomsJson, TellsZonesElse) {
  const DescriptorSequence recording = test::recordingOf({{1, 0}, {1, 0}, {0, 1}, {1, 0}});
  const auto json = ordered_json::parse(toRoomsJson(describeZones(recording, std::vector<int>{0, 0, 1, 2})));
  ASSERT_EQ(json.size(), 3U);
  EXPECT_EQ(json["word 0"]["images"], 2);
  EXPECT_EQ(json["word 1"]["images"], 1);
  EXPECT_EQ(json["word 0 (2)"]["words"]["word 0"], 1) << "the same name once more";
}

}  // namespace
}  // namespace estancia
