// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "estancia/core/error.hpp"
#include "estancia/figures/decision_chart.hpp"
#include "estancia/figures/word_cloud.hpp"
#include "estancia/report/map_figure.hpp"
#include "support/report_map.hpp"

namespace estancia::report {
namespace {

using test::sampleMap;

void expectPacked(const std::vector<PlacedWord>& words, double width, double height) {
  for (std::size_t i = 0; i < words.size(); ++i) {
    EXPECT_TRUE(words[i].box.inside({0, 0, width, height})) << words[i].text;
    for (std::size_t j = 0; j < i; ++j)
      EXPECT_FALSE(words[i].box.overlaps(words[j].box)) << words[i].text << " on " << words[j].text;
  }
}

TEST(WordCloud, WordsNeitherOverlapNorLeaveTheBox) {
  std::vector<std::pair<std::string, double>> words;
  for (int i = 0; i < 25; ++i) words.emplace_back("suspension bridge " + std::to_string(i), 1.0 / (1 + i));
  const auto placed = packWords(words, 340, 150);
  EXPECT_GE(placed.size(), 12U);
  expectPacked(placed, 340, 150);
}

TEST(WordCloud, AWordThatFitsAtNoSizeIsLeftOut) {
  const auto placed = packWords({{std::string(200, 'W'), 1}, {"small", 0.5}}, 340, 150);
  ASSERT_EQ(placed.size(), 1U);
  EXPECT_EQ(placed[0].text, "small");
  EXPECT_TRUE(packWords({}, 340, 150).empty());
}

TEST(MapFigure, NamesEveryRoomWhereThereIsSpace) {
  for (const bool poses : {true, false}) {
    const TopologicalMap map = sampleMap({.nodes = 20, .poses = poses});
    const MapSummary summary = summarize(map);
    const std::string svg =
        mapFigure(summary, layoutMap(summary, false), {heatMapOf(map, 0), nullptr}, nullptr, {}).str();
    for (const std::string& room : summary.rooms)
      EXPECT_NE(svg.find(">" + room + "</text>"), std::string::npos) << room;
  }
}

TEST(HeatMap, RanksNodesByTheLabel) {
  const TopologicalMap map = sampleMap();
  const HeatMap heat = heatMapOf(map, 0);
  EXPECT_EQ(heat.ranking(3).front(), 0U);
  EXPECT_EQ(heat.ranking(99).size(), map.nodes.size());
  EXPECT_EQ(heat.colorOf(0).hex(), viridis(1).hex());
  EXPECT_THROW(heatMapOf(map, 40), Error);
}

TEST(DecisionChart, ThinningKeepsEveryPeak) {
  std::vector<double> values(50'000, 0.5);
  values[12'345] = 0.9;
  values[23'456] = 0.1;
  const auto points = thinned(values, 500);
  EXPECT_LE(points.size(), 1000U);
  const auto [low, high] =
      std::minmax_element(points.begin(), points.end(), [](auto& a, auto& b) { return a.y < b.y; });
  EXPECT_EQ(high->x, 12'345);
  EXPECT_EQ(high->y, 0.9);
  EXPECT_EQ(low->x, 23'456);
  EXPECT_TRUE(std::is_sorted(points.begin(), points.end(), [](auto& a, auto& b) { return a.x < b.x; }));
}

TEST(DecisionChart, MissingDistancesBreakTheLineAndReachNoPath) {
  TopologicalMap map = sampleMap();
  map.decisions[2].toCurrent = std::numeric_limits<double>::infinity();
  const std::string svg = decisionChart(map).str();
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find("inf"), std::string::npos);
  EXPECT_NE(svg.find("4 splits, 5 revisits"), std::string::npos);
}

}  // namespace
}  // namespace estancia::report
