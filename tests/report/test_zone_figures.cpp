// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "estancia/figures/layout.hpp"
#include "estancia/report/zone_figures.hpp"
#include "sample_zones.hpp"
#include "support/html_checks.hpp"

namespace estancia::report {
namespace {

using test::count;
using test::sampleZones;

using Points = std::vector<std::optional<Point>>;

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
}

}  // namespace
}  // namespace estancia::report
