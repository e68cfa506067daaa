// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <sstream>

#include "estancia/query/quality.hpp"
#include "map_file/sample_map.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

TopologicalMap emptyMap() {
  return {.vocabulary = Vocabulary({"a"})};
}

/// `nodes` nodes without frames, of which the first `links` pairs (in order 0-1, 0-2, 1-2, 0-3 …) are linked.
TopologicalMap graphOf(std::size_t nodes, std::size_t links) {
  TopologicalMap map = emptyMap();
  for (std::size_t i = 0; i < nodes; ++i) map.nodes.push_back(test::nodeWith(static_cast<int>(i), 1, {1}));
  for (std::size_t b = 1; b < nodes; ++b)
    for (std::size_t a = 0; a < b && links > 0; ++a, --links)
      map.transitions.push_back({static_cast<int>(b), static_cast<int>(a), 1, 0});
  return map;
}

TEST(Quality, OfASmallFlatIsAsCountedByHand) {
  const MapQuality quality = evaluate(test::sampleMap());
  EXPECT_EQ(quality.nodes, 3U);
  EXPECT_EQ(quality.transitions, 3U);
  EXPECT_EQ(quality.links, 2U) << "1 → 3 and 3 → 1 are one link";
  EXPECT_EQ(quality.frames, 7U);
  ASSERT_TRUE(quality.rooms);
  EXPECT_DOUBLE_EQ(quality.rooms->vMeasure, 1);
  EXPECT_DOUBLE_EQ(quality.rooms->purity, 1);
  // kitchen and office frames are 0.5 m from their centers, hall frames at theirs
  EXPECT_DOUBLE_EQ(*quality.spatialSpread, 4 * 0.5 / 7);
  // the nodes lie at (0, 1), (4, 0) and (8, 1): of two images the upper median is the second
  const double extent = std::hypot(8, 1), link = std::hypot(4, 1);
  EXPECT_DOUBLE_EQ(*quality.original.roomPurity, 1);
  EXPECT_DOUBLE_EQ(quality.original.sparseness, 2.0 / 3);
  EXPECT_DOUBLE_EQ(*quality.original.linkCloseness, 1 - link / extent);
  EXPECT_DOUBLE_EQ(*quality.original.compactness, 1 - 2 * (0.5 + 0 + 0.5) / 3 / extent);
  EXPECT_DOUBLE_EQ(*quality.original.spread, 2 * std::sqrt(32.0 / 3 + 2.0 / 9) / extent);
  EXPECT_DOUBLE_EQ(*evaluate(test::sampleMap(), {}, 100).original.linkCloseness, 1 - link / 100);
  EXPECT_EQ(quality.trueLinks, 2U);
  EXPECT_DOUBLE_EQ(*quality.edgePrecision, 1);
  EXPECT_DOUBLE_EQ(*quality.edgeRecall, 1);
}

TEST(Quality, LeavesOutWhatNeedsRoomsOrPoses) {
  TopologicalMap map = test::sampleMap();
  for (MappedFrame& frame : map.frames) frame.room.clear();
  MapQuality quality = evaluate(map);
  EXPECT_FALSE(quality.rooms);
  EXPECT_FALSE(quality.original.roomPurity);
  EXPECT_FALSE(quality.original.total);
  EXPECT_FALSE(quality.edgePrecision);
  EXPECT_FALSE(quality.edgeRecall);
  EXPECT_TRUE(quality.spatialSpread);
  EXPECT_TRUE(quality.original.spread);
  map = test::sampleMap();
  for (MappedFrame& frame : map.frames) frame.pose.reset();
  quality = evaluate(map);
  EXPECT_TRUE(quality.rooms);
  EXPECT_TRUE(quality.edgeRecall);
  EXPECT_FALSE(quality.spatialSpread);
  EXPECT_FALSE(quality.original.linkCloseness);
  EXPECT_FALSE(quality.original.total);
}

TEST(Quality, PunishesFalseAndMissingLinks) {
  TopologicalMap map = test::sampleMap();
  map.transitions = {{0, 1, 1, 2}, {0, 3, 1, 4}};  // kitchen–office was never driven, hall–office is missing
  MapQuality quality = evaluate(map);
  EXPECT_DOUBLE_EQ(*quality.edgePrecision, 0.5);
  EXPECT_DOUBLE_EQ(*quality.edgeRecall, 0.5);
  for (MappedFrame& frame : map.frames) frame.room = "hall";
  quality = evaluate(map);
  EXPECT_DOUBLE_EQ(*quality.edgePrecision, 1) << "links inside a room are right";
  EXPECT_EQ(quality.trueLinks, 0U);
  EXPECT_FALSE(quality.edgeRecall) << "there is nothing to be found";
}

TEST(Quality, FallsWhenRoomsShareANode) {
  TopologicalMap map = test::sampleMap();
  for (MappedFrame& frame : map.frames)
    if (frame.room == "office") frame.room = "hall";
  map.frames[4].room = "kitchen";  // half of node 3
  const MapQuality quality = evaluate(map);
  EXPECT_DOUBLE_EQ(*quality.original.roomPurity, (1 + 1 + 0) / 3.0);
  EXPECT_LT(quality.rooms->homogeneity, 1);
  EXPECT_DOUBLE_EQ(quality.rooms->purity, 6.0 / 7);
}

TEST(Quality, IsDefinedForOneNodeButNotForNone) {
  TopologicalMap map = emptyMap();
  map.nodes = {test::nodeWith(0, 2, {1})};
  map.frames = {test::frameAt("a", 0, 3, 3, "hall"), test::frameAt("b", 0, 3, 3, "hall")};
  const MapQuality quality = evaluate(map);
  EXPECT_DOUBLE_EQ(quality.original.sparseness, 0);
  EXPECT_DOUBLE_EQ(*quality.original.linkCloseness, 1);
  EXPECT_DOUBLE_EQ(*quality.original.compactness, 1);
  EXPECT_DOUBLE_EQ(*quality.original.spread, 0);
  EXPECT_DOUBLE_EQ(*quality.original.total, 60);
  EXPECT_FALSE(quality.edgePrecision);
  EXPECT_THROW(evaluate(emptyMap()), Error);
}

/// The author's one-node maps of Minnie's sequences: their frames by room, and the A he printed.
TEST(Quality, HasTheAuthorsRoomPurity) {
  struct Sequence {
    std::array<int, 5> framesOfRoom;
    double purity;
  };
  for (const Sequence& sequence : {Sequence{{121, 401, 125, 112, 156}, 0.6795512},     // Cloudy1
                                   Sequence{{124, 398, 122, 115, 209}, 0.6419598},     // Cloudy2
                                   Sequence{{116, 408, 132, 108, 130}, 0.70220584},    // Cloudy3
                                   Sequence{{127, 425, 139, 123, 161}, 0.6764706},     // Cloudy4
                                   Sequence{{118, 386, 122, 98, 129}, 0.69753885},     // Sunny1
                                   Sequence{{111, 406, 131, 120, 122}, 0.7019704}}) {  // Sunny4
    TopologicalMap map = emptyMap();
    map.nodes = {test::nodeWith(0, 1, {1})};
    for (std::size_t room = 0; room < sequence.framesOfRoom.size(); ++room)
      for (int i = 0; i < sequence.framesOfRoom[room]; ++i)
        map.frames.push_back(test::frameAt("f", 0, i, 0, std::to_string(room)));
    EXPECT_NEAR(*evaluate(map).original.roomPurity, sequence.purity, 1e-7);
  }
}

/// All rows of the author's threshold sweeps: τ_other; τ_current; k; nodes; edges; A; B; C; D; E; metric.
TEST(Quality, AgreesWithTheAuthorsNumbers) {
  const auto data = test::findData("lextomap_reference");
  ESTANCIA_NEEDS(data, "the reference data (lextomap_reference) is not unpacked");
  std::size_t rows = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(*data / "topomap_idol" / "resultados_WeigthDistance")) {
    if (!entry.path().string().ends_with("MetricsData.txt")) continue;
    std::ifstream file(entry.path());
    for (std::string line; std::getline(file, line);) {
      std::vector<double> values;
      std::stringstream fields(line);
      try {
        for (std::string field; std::getline(fields, field, ';');) values.push_back(std::stod(field));
      } catch (const std::exception&) {
        continue;  // a ruler between two sweeps
      }
      ASSERT_EQ(values.size(), 11U) << line;
      const auto nodes = static_cast<std::size_t>(values[3]), edges = static_cast<std::size_t>(values[4]);
      if (nodes == 2) continue;  // he printed NaN
      EXPECT_NEAR(20 * (values[5] + values[6] + values[7] + values[8] + values[9]), values[10], 1e-4) << line;
      EXPECT_NEAR(evaluate(graphOf(nodes, edges)).original.sparseness, values[6], 1e-6) << line;
      ++rows;
    }
  }
  EXPECT_GT(rows, 5000U);
  RecordProperty("rows", static_cast<int>(rows));
}

TEST(Quality, OfTheRoomsSeenIsToldBesideThatOfTheRoomsStoodIn) {
  TopologicalMap map = test::sampleMap();
  EXPECT_FALSE(evaluate(map).roomsSeen);
  // b.jpg is taken in the kitchen and looks into the hall; what d.jpg shows is unknown.
  const std::vector<std::string> seen{"kitchen", "hall", "hall", "", "office", "office", "hall"};
  const MapQuality quality = evaluate(map, seen);
  ASSERT_TRUE(quality.roomsSeen);
  EXPECT_EQ(quality.framesWithRoomSeen, 6U);
  EXPECT_DOUBLE_EQ(quality.roomsSeen->purity, 5.0 / 6);
  EXPECT_LT(quality.roomsSeen->vMeasure, 1);
  EXPECT_DOUBLE_EQ(quality.rooms->vMeasure, 1) << "the rooms stood in are judged as before";
  EXPECT_FALSE(evaluate(map, std::vector<std::string>(7)).roomsSeen);
  EXPECT_THAT([&] { evaluate(map, std::vector<std::string>(3)); }, test::FailsWith(ErrorCode::mismatch));
  map.frames[1].node = 77;
  EXPECT_EQ(evaluate(map, std::vector<std::string>(7, "hall")).framesWithRoomSeen, 6U) << "one is in no node";
}

}  // namespace
}  // namespace estancia
