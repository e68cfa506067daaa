// Rooms that a classifier has named: kept in the map file, asked, exported, explained and judged.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "estancia/map_file/places.hpp"
#include "estancia/map_file/sqlite.hpp"
#include "estancia/map_file/store.hpp"
#include "estancia/query/ask.hpp"
#include "estancia/query/explain.hpp"
#include "estancia/query/export.hpp"
#include "estancia/query/quality.hpp"
#include "estancia/query/route.hpp"
#include "estancia/session/session.hpp"
#include "map_file/sample_map.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::FailsWith;
using testing::ElementsAre;
using testing::IsEmpty;

/// The last of the sample map's seven frames was mapped later. Frame c is taken for an office.
RoomPredictions predictions() {
  RoomPredictions made{"svm-rbf on test", {"entrance hall", "kitchen", "office"}, DescriptorMatrix(3)};
  const std::vector<float> kitchen{0.125F, 0.75F, 0.125F}, office{0.125F, 0.125F, 0.75F};
  const std::vector<std::vector<float>> rows{
      kitchen, kitchen, {0.25F, 0.125F, 0.625F}, {0.625F, 0.125F, 0.25F}, office, office};
  for (const auto& row : rows) made.probabilities.append(row);
  return made;
}

TopologicalMap namedMap() {
  TopologicalMap map = test::sampleMap();
  map.predictions = predictions();
  for (MappedFrame& frame : map.frames)
    if (frame.room == "hall") frame.room = "entrance hall";
  return map;
}

TopologicalMap withoutTruth(TopologicalMap map) {
  for (MappedFrame& frame : map.frames) frame.room.clear();
  return map;
}

TEST(PredictedRooms, NameThePlaces) {
  const std::vector<Place> places = placesOf(withoutTruth(namedMap()));
  EXPECT_EQ(places[0].predicted.front().room, "kitchen");
  EXPECT_NEAR(places[0].predicted.front().probability, 0.75, 1e-6);
  EXPECT_EQ(places[1].predicted.back().room, "kitchen");
  // √(0.25 · 0.625) / (2 √(0.25 · 0.625) + 0.125)
  EXPECT_NEAR(places[1].predicted.front().probability, 0.4317365, 1e-6);
  EXPECT_EQ(places[2].predicted.front().room, "office");
  EXPECT_EQ(places[0].room, "") << "what is predicted is never the truth";
  EXPECT_EQ(places[0].displayRoom(), "kitchen 75 %");
  EXPECT_EQ(placesOf(namedMap())[2].displayRoom(), "office");
  EXPECT_EQ(placesOf(withoutTruth(test::sampleMap()))[0].displayRoom(), "");
}

TEST(PredictedRooms, AreAskedAndDrivenTo) {
  const Answers answers = ask(namedMap(), "Offices");
  EXPECT_THAT(answers.rooms, ElementsAre("office"));
  EXPECT_THAT(answers.labels, IsEmpty());
  EXPECT_EQ(answers.places[0].node, 3);
  EXPECT_NEAR(answers.places[0].probability, 0.75, 1e-6);
  EXPECT_EQ(answers.places[0].room, "office");
  EXPECT_EQ(answers.places[0].rank, 1U);
  EXPECT_EQ(answers.places[1].node, 1);
  EXPECT_LE(answers.places[1].rank, 2U);
  // (2 · 0.125 + 3 · 0.4317 + 2 · 0.75) / 7
  EXPECT_NEAR(answers.places[0].lift, 0.75 / (3.0452094 / 7), 1e-5);
  const WordRoute way = routeToWords(namedMap(), 0, "office");
  EXPECT_THAT(way.route.nodes, ElementsAre(0, 1, 3));
  EXPECT_EQ(way.goal.room, "office");
}

TEST(PredictedRooms, GiveWayToLabelsUnlessTheyAreNamedThemselves) {
  TopologicalMap map = namedMap();
  EXPECT_THAT(findMeaning(map, "umbrella").labels, ElementsAre(3U));
  EXPECT_THAT(findMeaning(map, "hall").rooms, ElementsAre("entrance hall")) << "no label of that name";
  map.vocabulary = Vocabulary({"coffee mug", "cup, mug", "hall", "umbrella", "kitchen"});
  EXPECT_THAT(findMeaning(map, "hall").labels, ElementsAre(2U));
  EXPECT_THAT(findMeaning(map, "kitchen").rooms, ElementsAre("kitchen")) << "the classifier was taught it";
  EXPECT_THAT(findMeaning(map, "kitchen").labels, IsEmpty());
  EXPECT_TRUE(findMeaning(map, "xylophone").empty());
  EXPECT_TRUE(findMeaning(test::sampleMap(), "office").empty());
}

TEST(PredictedRooms, AreExportedBesideTheTruth) {
  const json places = json::parse(exportMap(namedMap(), "json"));
  EXPECT_EQ(places["places"][0]["room"], "kitchen");
  EXPECT_EQ(places["places"][0]["predicted_rooms"][0], (json{{"room", "kitchen"}, {"p", 0.75}}));
  EXPECT_EQ(json::parse(exportMap(withoutTruth(namedMap()), "json"))["places"][2]["room"], nullptr);
  EXPECT_NE(exportMap(namedMap(), "graphml").find("<data key=\"predicted_room\">office</data>"),
            std::string::npos);
  EXPECT_EQ(exportMap(test::sampleMap(), "graphml").find("<data key=\"predicted_room\""), std::string::npos);
  const json nav2 = json::parse(exportMap(withoutTruth(namedMap()), "nav2"));
  EXPECT_EQ(nav2["features"][2]["properties"]["metadata"]["class"], "office");
  EXPECT_EQ(nav2["features"][2]["properties"]["metadata"]["predicted_room"], "office");
  EXPECT_FALSE(nav2["features"][2]["properties"]["metadata"].contains("room"));
}

TEST(PredictedRooms, AreExplained) {
  EXPECT_EQ(explain(namedMap(), 2).size(), explain(test::sampleMap(), 2).size() + 1);
  EXPECT_EQ(explain(namedMap(), 6), explain(test::sampleMap(), 6)) << "nothing was said of the last frame";
}

TEST(PredictedRooms, AreJudgedByTheTruth) {
  const MapQuality quality = evaluate(namedMap());
  EXPECT_DOUBLE_EQ(*quality.predictedRoom, 5.0 / 6) << "frame c is not in an office";
  EXPECT_GE(*quality.predictedNodeRoom, 4.0 / 6) << "nodes 0 and 3; node 1 may be either";
  EXPECT_FALSE(evaluate(withoutTruth(namedMap())).predictedRoom);
  EXPECT_FALSE(evaluate(test::sampleMap()).predictedRoom);
}

fs::path storedMap(const test::ScratchFolder& folder, bool named = true) {
  const TopologicalMap map = test::sampleMap();
  const fs::path path = folder / "map.estancia";
  MapStore store = MapStore::create(path, {map.vocabulary, "model-1", "{}"});
  for (const Node& node : map.nodes) store.putNode(node, "");
  for (std::size_t i = 0; i < map.frames.size(); ++i) {
    MappedFrame frame = map.frames[i];
    frame.number = i;
    store.addFrame(frame, LexicalDescriptor(map.vocabulary.size(), 0.2F));
  }
  if (named) store.putPredictions(predictions());
  store.commit();
  return path;
}

std::int64_t versionOf(const fs::path& path) {
  const std::string bytes = test::readFile(path);
  constexpr std::size_t userVersion = 60;  // in SQLite's header, big-endian
  std::int64_t version = 0;
  for (std::size_t i = 0; i < 4; ++i)
    version = version << 8 | static_cast<unsigned char>(bytes[userVersion + i]);
  return version;
}

TEST(PredictedRooms, AreKeptInTheMapFileUntilTheyAreReplaced) {
  const test::ScratchFolder folder;
  const fs::path path = storedMap(folder);
  EXPECT_EQ(versionOf(path), 6);
  const auto kept = readMap(path).predictions;
  ASSERT_TRUE(kept);
  EXPECT_EQ(kept->classifier, "svm-rbf on test");
  EXPECT_EQ(kept->rooms, predictions().rooms);
  EXPECT_EQ(kept->probabilities.values(), predictions().probabilities.values());

  RoomPredictions later{"later", {"a", "b"}, DescriptorMatrix(2)};  // predictions of some frames
  for (const float first : {0.25F, 0.0F, 0.5F, 0.0F})
    later.probabilities.append(std::vector<float>{first, 2 * first});
  writeRoomPredictions(later, path);
  const TopologicalMap map = readMap(path);
  EXPECT_EQ(map.predictions->classifier, "later");
  EXPECT_THAT(map.predictions->rooms, ElementsAre("a", "b"));
  ASSERT_EQ(map.predictions->probabilities.size(), 3U) << "up to the last that was predicted";
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(isPredicted(*map.predictions, i), i != 1) << i;
  EXPECT_EQ(map.frames[0].room, "kitchen") << "the truth stays what it was";
}

/// By name alone, without a list: the kitchen of places 0 and 1 rests on one label.
RoomPredictions byName() {
  RoomPredictions made = predictions();
  made.areByName = true;
  made.prior.assign(3, 1.0 / 3);
  for (std::size_t i = 0; i < 3; ++i) made.evidence.push_back({i, 1, {0, 3, 0}});
  return made;
}

TEST(PredictedRooms, ByNameAloneAreKeptWithTheirEvidence) {
  const test::ScratchFolder folder;
  const fs::path path = storedMap(folder, false);
  writeRoomPredictions(byName(), path);
  const RoomPredictions kept = *readMap(path).predictions;
  ASSERT_EQ(kept.evidence.size(), 3U);
  EXPECT_EQ(kept.evidence[2].image, 2U);
  EXPECT_EQ(kept.evidence[2].label, 1U);
  EXPECT_THAT(kept.evidence[2].logOdds, ElementsAre(0, 3, 0));
  writeRoomPredictions(predictions(), path);
  EXPECT_TRUE(readMap(path).predictions->evidence.empty());
}

TEST(PredictedRooms, ByNameAloneNameOnlyWhatTheySurelyAre) {
  TopologicalMap map = withoutTruth(namedMap());
  map.predictions = byName();
  const std::vector<Place> places = placesOf(map);
  EXPECT_FALSE(places[0].isNamed) << "one label";
  EXPECT_EQ(places[0].predicted.front().room, "kitchen");
  EXPECT_EQ(places[0].displayRoom(), "");
  EXPECT_EQ(places[2].displayRoom(), "office 75 %");
  EXPECT_THAT(findMeaning(map, "office").rooms, ElementsAre("office"));
  EXPECT_THAT(findMeaning(map, "kitchen").rooms, IsEmpty()) << "perhaps there is none";
  const json nav2 = json::parse(exportMap(map, "nav2"));
  EXPECT_NE(nav2["features"][0]["properties"]["metadata"]["class"], "kitchen");
  EXPECT_FALSE(nav2["features"][0]["properties"]["metadata"].contains("predicted_room"));
  EXPECT_EQ(nav2["features"][2]["properties"]["metadata"]["class"], "office");
  map.predictions->areListed = true;
  EXPECT_THAT(findMeaning(map, "kitchen").rooms, ElementsAre("kitchen")) << "somebody said that there is one";
}

TEST(PredictedRooms, ThatFitNoMapAreRefused) {
  const test::ScratchFolder folder;
  const fs::path path = storedMap(folder, false);
  const std::pair<ErrorCode, void (*)(RoomPredictions&)> changes[] = {
      {ErrorCode::mismatch, [](RoomPredictions& p) { p.rooms.pop_back(); }},
      {ErrorCode::invalidInput, [](RoomPredictions& p) { p.rooms[1].clear(); }},
      {ErrorCode::mismatch, [](RoomPredictions& p) { p.evidence[0].label = 99; }},
      {ErrorCode::mismatch,
       [](RoomPredictions& p) {
         for (int i = 0; i < 2; ++i) p.probabilities.append(std::vector<float>{0, 0, 1});
       }},
      {ErrorCode::labelerFailure, [](RoomPredictions& p) {
         p.probabilities.append(std::vector<float>{0, 0, 7});
       }}};
  for (const auto& [code, change] : changes) {
    RoomPredictions made = byName();
    change(made);
    EXPECT_THAT([&] { writeRoomPredictions(made, path); }, FailsWith(code));
  }
  EXPECT_FALSE(readMap(path).predictions) << "nothing of it was kept";
}

TEST(PredictedRooms, InADamagedFileAreNotBelieved) {
  for (const char* sql :
       {"UPDATE predictions SET probabilities = x'00' WHERE frame = 1",
        "UPDATE predictions SET probabilities = x'0000c07f0000000000000000' WHERE frame = 2",
        "UPDATE predictions SET probabilities = x'0000004100000000000000c1' WHERE frame = 2",
        "INSERT INTO predictions VALUES(7, zeroblob(12))", "UPDATE predicted_rooms SET id = 9 WHERE id = 1",
        "UPDATE predicted_rooms SET name = ''", "DELETE FROM predicted_rooms",
        "DELETE FROM meta WHERE key = 'classifier'", "DROP TABLE predictions",
        "UPDATE meta SET value = '{' WHERE key = 'rooms_by_name'",
        "UPDATE meta SET value = '{\"prior\": [0.5, 0.5], \"listed\": true}' WHERE key = 'rooms_by_name'",
        "UPDATE meta SET value = '{\"prior\": [0, 1, 1], \"listed\": true}' WHERE key = 'rooms_by_name'",
        "UPDATE meta SET value = '{\"prior\": [1, 1, 2], \"listed\": true}' WHERE key = 'rooms_by_name'",
        "UPDATE room_evidence SET label = 99 WHERE frame = 1",
        "UPDATE room_evidence SET frame = 99 WHERE frame = 1",
        "UPDATE room_evidence SET log_odds = x'00' WHERE frame = 1",
        "UPDATE room_evidence SET log_odds = x'0000c07f0000000000000000' WHERE frame = 1"}) {
    const test::ScratchFolder folder;
    const fs::path path = storedMap(folder, false);
    writeRoomPredictions(byName(), path);
    sqlite::Database(path, sqlite::Database::Mode::write).run(sql);
    EXPECT_THAT([&] { readMap(path); }, FailsWith(ErrorCode::corruptFile)) << sql;
  }
}

}  // namespace
}  // namespace estancia
