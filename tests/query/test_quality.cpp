// What maps and localizations are worth, by the truth and by the thesis author's own numbers.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <sstream>

#include "estancia/query/accuracy.hpp"
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

/// Frames 0 … 4 at 0, 1, 2, 3, 4 m, looking along x; frame 5 at 0 m looks back.
TopologicalMap corridorMap() {
  TopologicalMap map{.vocabulary = Vocabulary({"x"})};
  map.nodes.push_back({});
  for (int i = 0; i < 6; ++i) {
    MappedFrame frame;
    frame.pose = i < 5 ? Pose::planar(i, 0, 0) : Pose::planar(0, 0, 3.1);
    map.frames.push_back(frame);
  }
  return map;
}

Frame at(double x, double heading) {
  Frame frame;
  frame.pose = Pose::planar(x, 0, heading);
  return frame;
}

Localization nearest(std::size_t image, std::size_t believed) {
  Localization answer;
  answer.nearestImage = image;
  answer.beliefImage = believed;
  return answer;
}

LocalizationAccuracy measured(const std::vector<Frame>& frames, const std::vector<Localization>& answers,
                              const AdmissibleImages& admissible = {}) {
  std::vector<std::size_t> numbers;
  for (std::size_t i = 0; i < frames.size(); ++i) numbers.push_back(i);
  return measureLocalization(corridorMap(), frames, numbers, answers, admissible,
                             {.nearDistance = 0.7, .nearAngle = 30});
}

TEST(LocalizationAccuracy, RecallCountsTheFramesOfWhichTheMapHasTheView) {
  const auto accuracy = measured({at(1.2, 0.4), at(0.3, 3.1), at(2.6, 0), at(2, 1.5), at(9, 0)},
                                 {nearest(1, 2), nearest(0, 5), nearest(3, 2), nearest(2, 2), nearest(4, 4)});
  EXPECT_EQ(accuracy.frames, 5U);
  EXPECT_DOUBLE_EQ(accuracy.nearestImage.recall.value(), 2.0 / 3);  // the last two have no such view
  EXPECT_DOUBLE_EQ(accuracy.belief.recall.value(), 2.0 / 3);
}

TEST(LocalizationAccuracy, ATableOfAdmissibleImagesGoesBeforePoses) {
  const auto accuracy = measured({at(1, 0), at(2, 0)}, {nearest(1, 4), nearest(3, 4)}, {{4}, {3, 4}});
  EXPECT_DOUBLE_EQ(accuracy.nearestImage.recall.value(), 0.5);
  EXPECT_DOUBLE_EQ(accuracy.belief.recall.value(), 1);
  EXPECT_FALSE(measured({Frame(), Frame()}, {nearest(0, 0), nearest(1, 1)}).nearestImage.recall)
      << "neither poses nor a table";
}

TEST(LocalizationAccuracy, ATableOfAdmissibleImagesIsReadLineByLine) {
  const test::ScratchFolder folder;
  const auto read = [&](const std::string& lines) {
    test::writeFile(folder / "truth.csv", "query,refs\n" + lines);
    return readAdmissibleImages(folder / "truth.csv");
  };
  const AdmissibleImages admissible = read("0,4 5\r\n\n1,\n2, 7\n");
  EXPECT_EQ(admissible, (AdmissibleImages{{4, 5}, {}, {7}}));
  for (const char* lines : {"0", "1,4\n", "x,4\n", "0,4 x\n", "0,-4\n", "0,4\n0,4\n"})
    EXPECT_THAT([&] { read(lines); }, test::FailsWith(ErrorCode::malformedFile)) << lines;
  EXPECT_THAT([&] { readAdmissibleImages(folder / "none.csv"); }, test::FailsWith(ErrorCode::fileUnreadable));
  EXPECT_THAT(
      [&] {
        measured({at(1, 0), at(2, 0)}, {nearest(1, 4), nearest(3, 4)}, {{4}});
      },
      test::FailsWith(ErrorCode::mismatch));
  EXPECT_THAT([&] { measured({at(1, 0)}, {}); }, test::FailsWith(ErrorCode::mismatch));
}

TEST(LocalizationAccuracy, AZoneIsInTheRoomOfMostOfItsFrames) {
  TopologicalMap map = corridorMap();
  for (std::size_t i = 0; i < 6; ++i) map.frames[i].room = i < 4 ? "hall" : "bath";
  const std::vector<int> zoneOf{0, 0, 0, 1, 1, 1};
  std::vector<Frame> frames(4);
  std::vector<Localization> answers(4);
  const std::pair<const char*, int> asked[] = {{"hall", 0}, {"bath", 1}, {"bath", 0}, {"", 1}};
  for (std::size_t i = 0; i < 4; ++i) {
    frames[i].room = asked[i].first;
    answers[i].beliefZone = asked[i].second;
  }
  const auto accuracy = measureLocalization(map, frames, {0, 1, 2, 3}, answers, {}, {}, zoneOf);
  EXPECT_DOUBLE_EQ(accuracy.beliefZoneRoom.value(), 2.0 / 3);
  EXPECT_FALSE(
      measureLocalization(map, frames, {0, 1, 2, 3}, std::vector<Localization>(4), {}, {}).beliefZoneRoom);
}

TEST(LocalizationSummary, NeedsNoTruth) {
  std::vector<Localization> answers(5);
  const int nodes[] = {3, 1, 3, 3, 1};
  const double confidences[] = {0.9, 0.25, 0.5, 0.75, 0.125};
  for (std::size_t i = 0; i < 5; ++i) {
    answers[i].beliefNode = nodes[i];
    answers[i].confidence = confidences[i];
  }
  LocalizationSummary summary = summarizeLocalization(answers);
  EXPECT_EQ(summary.medianConfidence, 0.5);
  EXPECT_FALSE(summary.unmapped) << "the map has no poses";
  ASSERT_EQ(summary.places.size(), 2U);
  EXPECT_EQ(summary.places[0].node, 3);
  EXPECT_EQ(summary.places[0].frames, 3U);
  EXPECT_EQ(summary.places[0].medianConfidence, 0.75);
  for (std::size_t i = 0; i < 5; ++i) answers[i].unmapped = i < 2 ? 0.9 : 0.1;
  EXPECT_EQ(summarizeLocalization(answers).unmapped, 0.4);
  EXPECT_FALSE(summarizeLocalization({}).medianConfidence);
}

/// X of his plan: all six one-node maps of his sweeps give it.
constexpr double extent = 31.1725;

/// The images of a sequence by their rooms and poses (frame,timestamp,x,y,theta,room), none in a node yet.
TopologicalMap sequenceOf(const std::filesystem::path& file) {
  TopologicalMap map{.vocabulary = Vocabulary({"a"})};
  std::ifstream rows(file);
  std::string row;
  for (std::getline(rows, row); std::getline(rows, row);) {
    std::stringstream fields(row);
    std::vector<std::string> values;
    for (std::string value; std::getline(fields, value, ',');) values.push_back(value);
    map.frames.push_back(
        test::frameAt(values.at(0), 0, std::stod(values.at(2)), std::stod(values.at(3)), values.at(5)));
  }
  return map;
}

/// A stay in a node, up to and with its `last` image, counted from 1.
struct Stay {
  int node;
  std::size_t last;
};

/// Links and nodes follow from the stays.
void addStays(TopologicalMap& map, const std::vector<Stay>& stays) {
  std::size_t image = 0;
  for (std::size_t i = 0; i < stays.size(); ++i) {
    if (map.findNode(stays[i].node) == nullptr) map.nodes.push_back(test::nodeWith(stays[i].node, 1, {1}));
    if (i > 0) map.transitions.push_back({stays[i - 1].node, stays[i].node, 1, image});
    while (image < stays[i].last) map.frames.at(image++).node = stays[i].node;
  }
  ASSERT_EQ(image, map.frames.size());
}

TEST(AuthorsMaps, OfOneNodeHaveHisCompactness) {
  const auto data = test::findData("idol2_meta");
  ESTANCIA_NEEDS(data, "the poses of KTH-IDOL2 (idol2_meta) are not unpacked");
  for (const auto& [sequence, compactness] : {std::pair{"cloudy1", 0.54896754},
                                              {"cloudy2", 0.5474267},
                                              {"cloudy3", 0.60777307},
                                              {"cloudy4", 0.5687177},
                                              {"sunny1", 0.5557833},
                                              {"sunny4", 0.5488793}}) {
    TopologicalMap map = sequenceOf(*data / (std::string("minnie_") + sequence + ".csv"));
    map.nodes = {test::nodeWith(0, 1, {1})};
    EXPECT_NEAR(*evaluate(map, {}, extent).original.compactness, compactness, 5e-6) << sequence;
  }
}

/// τ_join .015, τ_revisit .0015, k 15, of 2016-04-28: as his list of links has the images.
TEST(AuthorsMaps, OfCloudy3HasTheScoreThatHePrinted) {
  const auto data = test::findData("idol2_meta");
  ESTANCIA_NEEDS(data, "the poses of KTH-IDOL2 (idol2_meta) are not unpacked");
  TopologicalMap map = sequenceOf(*data / "minnie_cloudy3.csv");
  addStays(map, {{0, 103},  {1, 147},  {2, 188},  {3, 194},  {4, 203},  {5, 213},  {6, 358},
                 {7, 471},  {8, 476},  {9, 488},  {10, 556}, {4, 560},  {11, 572}, {12, 611},
                 {13, 663}, {14, 740}, {15, 759}, {16, 818}, {17, 867}, {18, 894}});
  const MapQuality quality = evaluate(map, {}, extent);
  EXPECT_EQ(quality.nodes, 19U);
  EXPECT_EQ(quality.links, 19U);
  EXPECT_NEAR(*quality.original.roomPurity, 0.835196, 1e-6);
  EXPECT_NEAR(quality.original.sparseness, 0.941176, 1e-6);
  EXPECT_NEAR(*quality.original.linkCloseness, 0.888547, 1e-6);
  EXPECT_NEAR(*quality.original.compactness, 0.887774, 1e-6);
  EXPECT_NEAR(*quality.original.spread, 0.370342, 1e-6);
  EXPECT_NEAR(*quality.original.total, 78.4607, 1e-4);
  EXPECT_NEAR(quality.rooms->vMeasure, 0.536, 5e-4);
  EXPECT_NEAR(quality.rooms->purity, 0.826, 5e-4);
  EXPECT_NEAR(*evaluate(map).original.linkCloseness, 0.8496, 1e-4) << "X is 23.1 m, the box of the poses";
}

TEST(AuthorsMaps, OfSunny1IsBetweenTheRowsOfHisSweep) {
  const auto data = test::findData("idol2_meta");
  ESTANCIA_NEEDS(data, "the poses of KTH-IDOL2 (idol2_meta) are not unpacked");
  TopologicalMap map = sequenceOf(*data / "minnie_sunny1.csv");
  addStays(map, {{0, 62},   {1, 98},   {2, 125},  {3, 163},  {4, 199},  {5, 234},  {6, 341},  {7, 381},
                 {8, 391},  {9, 432},  {10, 442}, {11, 463}, {12, 465}, {13, 534}, {14, 537}, {15, 563},
                 {16, 578}, {17, 619}, {18, 660}, {19, 703}, {20, 704}, {21, 705}, {20, 725}, {22, 726},
                 {23, 765}, {24, 775}, {25, 803}, {26, 816}, {27, 853}});
  const MapQuality quality = evaluate(map, {}, extent);
  EXPECT_EQ(quality.nodes, 28U);
  EXPECT_GT(*quality.original.total, 81.62298) << "27 nodes, by a τ_revisit of .002";
  EXPECT_LT(*quality.original.total, 82.19306) << "29 nodes, by one of .001";
  EXPECT_NEAR(quality.rooms->vMeasure, 0.553, 5e-4);
  EXPECT_NEAR(quality.rooms->purity, 0.900, 5e-4);
}

}  // namespace
}  // namespace estancia
