// Figures and measures of reports.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "estancia/core/error.hpp"
#include "estancia/figures/decision_chart.hpp"
#include "estancia/figures/layout.hpp"
#include "estancia/figures/word_cloud.hpp"
#include "estancia/query/accuracy.hpp"
#include "estancia/query/quality.hpp"
#include "estancia/report/map_figure.hpp"
#include "estancia/report/measures.hpp"
#include "estancia/report/zone_figures.hpp"
#include "estancia/world_query/evaluate_world.hpp"
#include "estancia/zones/measure.hpp"
#include "report/sample_zones.hpp"
#include "support/html_checks.hpp"
#include "support/report_map.hpp"

namespace estancia::report {
namespace {

using Points = std::vector<std::optional<Point>>;
using test::count;
using test::sampleMap;
using test::sampleZones;

std::ptrdiff_t placeOf(const std::vector<Measure>& measures, const std::string& key) {
  const auto found = std::find_if(measures.begin(), measures.end(),
                                  [&key](const Measure& measure) { return measure.key == key; });
  return found == measures.end() ? -1 : found - measures.begin();
}

template <typename Quality>
void expectRoomsToBeCounted() {
  Quality quality;
  EXPECT_EQ(placeOf(measuresOf(quality), "frames_with_room"), -1);
  EXPECT_GT(placeOf(measuresOf(quality), "v_measure"), 0) << "unknown, but not left out";
  quality.framesWithRoom = 3;
  quality.rooms = Agreement{};
  const auto measures = measuresOf(quality);
  const auto frames = placeOf(measures, "frames_with_room");
  ASSERT_GT(frames, 0);
  EXPECT_EQ(measures.at(static_cast<std::size_t>(frames)).value, 3);
  EXPECT_EQ(placeOf(measures, "v_measure"), frames + 1) << "it tells of the next five";
  EXPECT_EQ(placeOf(measures, "purity"), frames + 5);
  EXPECT_EQ(placeOf(measures, "seen_purity"), -1) << "not known by most";
  quality.framesWithRoomSeen = 2;
  quality.roomsSeen = Agreement{.purity = 0.5};
  const auto seen = measuresOf(quality);
  const auto purity = placeOf(seen, "seen_purity");
  EXPECT_EQ(placeOf(seen, "frames_with_seen_room"), frames + 6);
  ASSERT_EQ(purity, frames + 11);
  EXPECT_EQ(seen.at(static_cast<std::size_t>(purity)).value, 0.5);
}

TEST(Measures, WhatIsNotKnownOfAWorldIsLeftOut) {
  EXPECT_TRUE(measuresOf(WorldAccuracy{}).empty());
  WorldAccuracy accuracy{.areas = 2, .objects = InstanceAccuracy{}};
  EXPECT_EQ(placeOf(measuresOf(accuracy), "split_things"), -1);
  EXPECT_EQ(placeOf(measuresOf(accuracy), "area_v_measure"), -1);
  accuracy.objects->split = accuracy.objects->merged = 3;
  EXPECT_GT(placeOf(measuresOf(accuracy), "merged_objects"), 0);
}

TEST(Measures, ImagesWithARoomAreCountedWhereThereAreSome) {
  expectRoomsToBeCounted<MapQuality>();
  expectRoomsToBeCounted<ZoneQuality>();
}

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
  TopologicalMap map = sampleMap();
  const HeatMap heat = heatMapOf(map, 0);
  EXPECT_EQ(heat.ranking(3).front(), 0U);
  EXPECT_EQ(heat.ranking(99).size(), map.nodes.size());
  EXPECT_EQ(heat.colorOf(0).hex(), viridis(1).hex());
  EXPECT_THROW(heatMapOf(map, 40), Error);
  for (Node& node : map.nodes) node.mean[3] = 0;
  EXPECT_TRUE(heatMapOf(map, 3).ranking(99).empty()) << "no node has it";
  EXPECT_EQ(heatMapOf(map, 3).colorOf(0).hex(), viridis(0).hex());
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

TEST(ZoneSymbols, ImagesOfOnePlaceStandApartAndByZone) {
  const Points points(12, Point{100, 100});
  std::vector<std::size_t> zoneOf(12, 0);
  for (std::size_t i = 0; i < 12; i += 2) zoneOf[i] = 1;
  const auto symbols = placeSymbols(points, zoneOf, 10, 1000);
  ASSERT_EQ(symbols.size(), 12U);
  double inner = 0, outer = 0;
  for (std::size_t i = 0; i < 12; ++i) {
    for (std::size_t j = 0; j < i; ++j)
      EXPECT_GT(std::hypot(symbols[i].at.x - symbols[j].at.x, symbols[i].at.y - symbols[j].at.y), 5);
    (symbols[i].zone == 0 ? inner : outer) += std::hypot(symbols[i].at.x - 100, symbols[i].at.y - 100);
  }
  EXPECT_LT(inner, outer);
}

TEST(ZoneSymbols, LongRunsAreDrawnSparselyWithoutLosingAZone) {
  Points points;
  std::vector<std::size_t> zoneOf;
  for (std::size_t i = 0; i < 50'000; ++i) {
    const double along = static_cast<double>(i) / 100;
    points.emplace_back(Point{300 + 250 * std::cos(along), 250 + 200 * std::sin(1.7 * along)});
    zoneOf.push_back(i == 777 ? 9 : i / 10'000);
  }
  const auto symbols = placeSymbols(points, zoneOf, 5, 3000);
  EXPECT_LE(symbols.size(), 3000U);
  EXPECT_GE(symbols.size(), 1000U);
  std::set<std::size_t> zones;
  for (const ZoneSymbol& symbol : symbols) zones.insert(symbol.zone);
  EXPECT_EQ(zones, (std::set<std::size_t>{0, 1, 2, 3, 4, 9}));
}

TEST(ZoneFigure, EverySymbolIsInsideTheFigure) {
  for (const bool onePlace : {false, true}) {
    Zones zones = sampleZones({.zones = 7, .imagesPerZone = 40});
    if (onePlace)
      for (Frame& frame : zones.frames) frame.pose = Pose{};
    std::vector<std::optional<Pose>> poses;
    for (const Frame& frame : zones.frames) poses.push_back(frame.pose);
    const std::string svg = zoneFigure(summarize(zones), projectPath(poses), {}).str();
    EXPECT_EQ(svg.find("nan"), std::string::npos);
    EXPECT_EQ(svg.find("inf"), std::string::npos);
    EXPECT_EQ(count(svg, "class=\"zone\""), 7U);
    EXPECT_EQ(count(svg, "class=\"scale\""), onePlace ? 0U : 1U) << "one place has no scale";
    for (std::size_t at = svg.find(" d=\"M"); at != std::string::npos; at = svg.find(" d=\"M", at + 1)) {
      const double x = std::stod(svg.substr(at + 5));
      EXPECT_GT(x, 0);
      EXPECT_LT(x, 780);
    }
  }
}

TEST(TimeStrip, LongRunsShowWhatIsMostFrequent) {
  std::vector<int> zoneOf(10'000, 0);
  for (std::size_t i = 5000; i < 10'000; ++i) zoneOf[i] = i % 3 == 0 ? 2 : 1;
  const auto stays = staysOf(zoneOf, 500);
  ASSERT_EQ(stays.size(), 2U);
  EXPECT_EQ(stays[1].zone, 1);
  EXPECT_EQ(stays[1].first, 5000U);
  EXPECT_EQ(stays.back().last, 9999U);
  EXPECT_TRUE(staysOf({}, 5).empty());
}

TEST(DendrogramTop, LargeTreesShowTheirLastMerges) {
  const Zones zones = sampleZones({.zones = 6, .imagesPerZone = 60});
  const DendrogramTop top = topOf(*zones.dendrogram, zones.zoneOf, 20);
  EXPECT_EQ(top.twigs.size(), 21U);
  EXPECT_EQ(top.branches.size(), 41U);
  std::size_t items = 0;
  for (const std::size_t twig : top.twigs) {
    EXPECT_TRUE(top.branches[twig].zone.has_value()) << "20 merges reach below the 6 zones";
    items += top.branches[twig].items;
  }
  EXPECT_EQ(items, zones.frames.size());
  std::set<std::size_t> all(top.twigs.begin(), top.twigs.end());
  EXPECT_EQ(all.size(), 21U) << "every twig once";
}

TEST(DendrogramFigure, NamesEveryZoneAndShowsTheCut) {
  const Zones zones = sampleZones({.zones = 6, .imagesPerZone = 60});
  const std::string svg = dendrogramFigure(summarize(zones), {}).str();
  for (int zone = 0; zone < 6; ++zone)
    EXPECT_EQ(count(svg, "data-zone=\"" + std::to_string(zone) + "\""), 1U) << zone;
  EXPECT_NE(svg.find("cut 0.5"), std::string::npos);
  EXPECT_NE(svg.find("the top 60 of 362 merges"), std::string::npos);
  const Zones many = sampleZones({.zones = 70, .imagesPerZone = 4, .labels = 70});
  ASSERT_GT(many.zones.size(), 61U);
  EXPECT_NE(dendrogramFigure(summarize(many), {}).str().find(" other"), std::string::npos)
      << "a twig stands for several zones";
}

TEST(RoomTable, CountsEveryImageWhoseRoomIsKnown) {
  Zones zones = sampleZones({.zones = 9, .imagesPerZone = 10});
  zones.frames[3].room.clear();
  for (const std::size_t columns : {40U, 4U}) {
    const RoomCounts counts = countRooms(zones, columns);
    ASSERT_EQ(counts.rooms.size(), 7U);
    std::size_t images = 0;
    for (const auto& row : counts.counts) {
      EXPECT_EQ(row.size(), std::min<std::size_t>(9, columns + 1));
      images += std::accumulate(row.begin(), row.end(), std::size_t{0});
    }
    EXPECT_EQ(images, zones.frames.size() - 1);
    const std::string html = roomTable(summarize(zones), counts).str();
    EXPECT_EQ(count(html, ">others<"), columns == 4 ? 1U : 0U);
    EXPECT_EQ(html.find("nan"), std::string::npos);
  }
  EXPECT_TRUE(countRooms(sampleZones({.rooms = false}), 40).rooms.empty());
  zones = sampleZones({.zones = 2, .imagesPerZone = 202, .dendrogram = false});
  for (std::size_t i = 0; i < zones.frames.size(); ++i) zones.frames[i].room = std::to_string(i % 203);
  const std::string html = roomTable(summarize(zones), countRooms(zones, 40)).str();
  EXPECT_NE(html.find(">3 rooms more are not shown.<"), std::string::npos);
}

}  // namespace
}  // namespace estancia::report
