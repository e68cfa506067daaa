// The thesis author's own maps of KTH-IDOL2, rebuilt: his metric comes out, and what his maps reach.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "estancia/query/quality.hpp"
#include "map_file/sample_map.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

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
