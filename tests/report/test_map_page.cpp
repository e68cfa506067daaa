// SPDX-License-Identifier: Apache-2.0
#include "estancia/report/map_page.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "estancia/core/error.hpp"
#include "estancia/words/label_concepts.hpp"
#include "sample_zones.hpp"
#include "support/errors.hpp"
#include "support/html_checks.hpp"
#include "support/report_map.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::count;
using test::expectNothingFromOutside;
using test::expectWellFormed;
using test::FailsWith;
using test::sampleMap;
using test::ScratchFolder;

const std::vector<unsigned char> jpeg{0xFF, 0xD8, 0xFF, 0xE0, 1, 2, 3};

MapPage withImages(const TopologicalMap& map, std::size_t bytes = 7) {
  MapPage page{map};
  for (std::size_t i = 0; i < map.frames.size(); ++i) page.images.frames.push_back(i);
  page.images.read = [bytes](std::size_t) {
    std::vector<unsigned char> image = jpeg;
    image.resize(bytes);
    return image;
  };
  return page;
}

nlohmann::json dataOf(const std::string& html) {
  const std::string start = "id=\"data\">";
  const std::size_t from = html.find(start) + start.size();
  return nlohmann::json::parse(html.substr(from, html.find("</script>", from) - from));
}

TEST(MapPage, ShowsNodesImagesDecisionsAndMeasures) {
  const TopologicalMap map = sampleMap();
  MapPage page = withImages(map);
  page.measures = {{"v", "V-measure", 0.94, 2, "Agreement with the rooms."}};
  page.sequence = "corridor";
  const std::string html = renderMapPage(page);
  EXPECT_EQ(count(html, "<article class=\"card\""), 5U);
  EXPECT_EQ(count(html, "<img "), 5U * 4);
  EXPECT_EQ(count(html, "class=\"node\""), 2U * 5) << "a wide and a narrow drawing";
  EXPECT_EQ(count(html, "<section id=\"decisions\">"), 1U);
  EXPECT_EQ(count(html, "<td class=\"value\">0.94</td><td>Agreement with the rooms.</td>"), 1U);
  EXPECT_EQ(count(html, "<dd>corridor</dd>"), 1U);
  EXPECT_EQ(count(html, "</svg>room 3</li>"), 1U) << "in the legend";
  EXPECT_EQ(count(html, "<img "), count(html, " alt=\"What node"));
  expectNothingFromOutside(html);
  expectWellFormed(html);
}

TEST(MapPage, HostileTextsStayTexts) {
  test::SampleOptions options;
  options.marker = test::hostileText;
  const TopologicalMap map = sampleMap(options);
  MapPage page = withImages(map);
  page.title = page.sequence = page.date = options.marker;
  page.measures = {{options.marker, options.marker, std::nullopt, 2, options.marker}};
  const std::string html = renderMapPage(page);
  expectWellFormed(html);
  EXPECT_EQ(count(html, "<script"), 2U) << "the data and the one script";
  EXPECT_EQ(count(html, "<img src=x"), 0U);
  EXPECT_EQ(count(html, "\xFF"), 0U);
  EXPECT_EQ(dataOf(html)["labels"].size(), 40U);
}

TEST(MapPage, TheSameMapGivesTheSameBytes) {
  const TopologicalMap map = sampleMap({.nodes = 12});
  EXPECT_EQ(renderMapPage(withImages(map)), renderMapPage(withImages(map)));
  const TopologicalMap unposed = sampleMap({.nodes = 12, .poses = false});
  EXPECT_EQ(renderMapPage({unposed}), renderMapPage({unposed}));
}

TEST(MapPage, AnEmptyMapSaysSo) {
  TopologicalMap map = sampleMap();
  map.nodes.clear();
  map.frames.clear();
  map.transitions.clear();
  map.decisions.clear();
  const std::string html = renderMapPage({map});
  expectWellFormed(html);
  EXPECT_EQ(count(html, "<p class=\"note\">"), 1U);
  EXPECT_EQ(count(html, "<section"), 0U);
}

TEST(MapPage, OneNodeWithoutPosesRoomsOrImagesIsAPage) {
  const TopologicalMap map = sampleMap({.nodes = 1, .poses = false, .rooms = false});
  const std::string html = renderMapPage({map});
  expectWellFormed(html);
  EXPECT_EQ(count(html, "class=\"node\""), 2U);
  for (const char* missing : {"class=\"driven\"", "class=\"scale\"", "id=\"by-rooms\"", "<img ", "nan"})
    EXPECT_EQ(count(html, missing), 0U) << missing;
}

TEST(MapPage, FamiliarWordsStandForSeveralLabels) {
  const TopologicalMap map = sampleMap({.nodes = 3, .rooms = false});
  MapPage page = withImages(map);
  const std::string raw = renderMapPage(page);
  EXPECT_EQ(count(raw, "thing"), 0U);
  const LabelConcepts none;
  page.concepts = &none;
  EXPECT_EQ(renderMapPage(page), raw);
  const LabelConcepts concepts{{"thing", 1, {0, 1, 2}, {0, 1, 2}}};
  page.concepts = &concepts;
  const std::string html = renderMapPage(page);
  expectWellFormed(html);
  EXPECT_EQ(count(html, "title=\"word0 0.6, word1 0.3, word2 0.2\">thing</span>"), 1U) << "bars of node 0";
  EXPECT_EQ(count(html, ">thing</text>"), 3U) << "in each cloud";
  EXPECT_EQ(count(html, "<h3>thing"), 1U) << "and what tells node 0 from the others";
  EXPECT_EQ(dataOf(html)["labels"], dataOf(raw)["labels"]) << "the search goes by the labels";
  page.cards = 0;
  EXPECT_NE(renderMapPage(page).find("thing 1.000"), std::string::npos) << "in rows, at most 1";
}

TEST(MapPage, StartsAsTheHeatMapOfAGivenLabel) {
  const TopologicalMap map = sampleMap();
  MapPage page{map};
  page.label = 7;
  const std::string html = renderMapPage(page);
  EXPECT_EQ(count(html, "“word7”"), 1U);
  EXPECT_EQ(count(html, "id=\"legend-rooms\" hidden"), 1U);
  EXPECT_EQ(count(html, "id=\"legend-heat\">"), 1U);
  page.label = 40;
  EXPECT_THAT([&] { renderMapPage(page); }, FailsWith(ErrorCode::invalidInput));
}

TEST(MapPage, TheIndexHoldsEveryLabelThatANodeMayBeFoundBy) {
  const TopologicalMap map = sampleMap();
  const nlohmann::json data = dataOf(renderMapPage({map}));
  const auto& row = data["index"][2];
  std::size_t label = 0, found = 0;
  for (std::size_t i = 0; i < row.size(); i += 2, ++found) {
    label += row[i].get<std::size_t>();
    EXPECT_NEAR(row[i + 1].get<double>() / 1e4, map.nodes[2].mean[label], 1e-4);
  }
  EXPECT_EQ(found, 40U);
}

TEST(MapPage, AThousandNodesStaySmallAndSayWhatIsLeftOut) {
  const TopologicalMap map = sampleMap({.nodes = 1000, .framesPerNode = 4, .labels = 1001, .poses = false});
  const std::string html = renderMapPage(withImages(map, 12'000));
  expectWellFormed(html);
  EXPECT_LT(html.size(), 6'000'000U);
  EXPECT_EQ(count(html, "<article class=\"card\""), 60U);
  EXPECT_EQ(count(html, "<img "), 150U) << "all that page.images.bytes allows";
  EXPECT_EQ(count(html, "<p class=\"note\">"), 1U) << "what is left out";
  EXPECT_GT(dataOf(html)["least"].get<double>(), 0.0005);
  EXPECT_EQ(count(html, "<article"), 1000U);
  MapPage folded{map};
  folded.cards = 999;
  EXPECT_EQ(count(renderMapPage(folded), "<article class=\"row\""), 1U);
}

TEST(MapPage, FloorPlanIsCheckedAndEmbedded) {
  const ScratchFolder scratch;
  test::writeFile(scratch / "plan.jpg", std::string(jpeg.begin(), jpeg.end()));
  test::writeFile(scratch / "plan.svg", "<svg/>");
  const auto read = [&](const char* name, double xMax) {
    return test::caught([&] { readFloorPlan(scratch / name, {0, 0, xMax, 1}); });
  };
  EXPECT_THAT(read("none.jpg", 1), FailsWith(ErrorCode::fileUnreadable));
  EXPECT_THAT(read("plan.svg", 1), FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT(read("plan.jpg", 0), FailsWith(ErrorCode::invalidOption));
  for (const double xMax : {static_cast<double>(NAN), 1e-300, 1e308})
    EXPECT_THAT(read("plan.jpg", xMax), FailsWith(ErrorCode::invalidOption)) << xMax;

  const TopologicalMap map = sampleMap(), unposed = sampleMap({.poses = false});
  MapPage page{map};
  page.floorPlan = readFloorPlan(scratch / "plan.jpg", {-10, -10, 10, 10});
  EXPECT_EQ(count(renderMapPage(page), "<image class=\"plan\""), 2U) << "wide and narrow";
  MapPage impossible{unposed};
  impossible.floorPlan = page.floorPlan;
  EXPECT_THAT([&] { renderMapPage(impossible); }, FailsWith(ErrorCode::insufficientData));
}

/// Two rooms that hold the ring of sampleMap(), or lie so far away.
FloorPlan homePlan(const ScratchFolder& scratch, double away) {
  test::writeFile(
      scratch / "home.json",
      fmt::format(R"({{"rooms": [{{"name": "west <wing>", "polygon": [[{0}, -20], [{1}, -20], [{1}, 20],
                                              [{0}, 20]]}},
                                             {{"name": "east", "polygon": [[{1}, -20], [{2}, -20], [{2}, 20], [{1}, 20]]}}],
                                   "doors": [{{"at": [{1}, 0], "axis": "y", "width": 1, "rooms": ["east"]}}],
                                   "windows": [{{"at": [{0}, 0], "axis": "y", "width": 2, "room": "east"}}]}})",
                  away - 20, away, away + 20));
  return readHomeFloorPlan(scratch.path());
}

TEST(MapPage, HomesAreDrawnWithTheirRoomsDoorsAndWindows) {
  const ScratchFolder scratch;
  const TopologicalMap map = sampleMap(), unnamed = sampleMap({.rooms = false}),
                       unposed = sampleMap({.poses = false});
  MapPage page{map};
  page.floorPlan = homePlan(scratch, 0);
  EXPECT_EQ(page.floorPlan->xMin, -20);
  EXPECT_EQ(page.floorPlan->yMax, 20);
  const std::string html = renderMapPage(page);
  expectWellFormed(html);
  expectNothingFromOutside(html);
  for (const auto& [kind, most] : {std::pair{"floor", 4U}, {"wall", 4U}, {"door", 2U}, {"window", 2U}})
    EXPECT_EQ(count(html, fmt::format("<path class=\"{}\"", kind)), most) << "wide and narrow";
  EXPECT_EQ(count(html, "wing"), 0U) << "rooms are named beside their nodes";
  MapPage named{unnamed};
  named.floorPlan = page.floorPlan;
  EXPECT_EQ(count(renderMapPage(named), "west &lt;wing&gt;"), 2U);

  MapPage impossible{unposed};
  impossible.floorPlan = page.floorPlan;
  EXPECT_THAT([&] { renderMapPage(impossible); }, FailsWith(ErrorCode::insufficientData));
  page.floorPlan = homePlan(scratch, 500);
  EXPECT_THAT([&] { renderMapPage(page); }, FailsWith(ErrorCode::mismatch)) << "another origin";
  EXPECT_THAT([&] { readHomeFloorPlan(scratch / "none"); }, FailsWith(ErrorCode::fileNotFound));
}

TEST(MapPage, CardsNameThePredictedRoomsAndTwelveNeighbors) {
  TopologicalMap map = sampleMap({.nodes = 20, .rooms = false});
  map.predictions = RoomPredictions{"knn", {"bureau", "kitchen"}, DescriptorMatrix(2)};
  for (std::size_t i = 0; i < map.frames.size(); ++i)
    map.predictions->probabilities.append(std::vector<float>{0.25F, 0.75F});
  for (int node = 1; node < 20; ++node) map.transitions.push_back({0, node, 1, 1});
  map.drives = {Drive{}, Drive{.firstFrame = 60}};
  const std::string html = renderMapPage({map});
  expectWellFormed(html);
  EXPECT_EQ(count(html, "Taken for kitchen 75 %"), 20U);
  EXPECT_EQ(count(html, "<h3>kitchen</h3>"), 20U) << "where the true room is not known";
  EXPECT_EQ(count(html, " and 7 more"), 1U);
  EXPECT_EQ(count(html, "<dt>drives</dt><dd>2</dd>"), 1U);
}

/// Zones of the frames of a map: its nodes 0 and 1 are one zone, all others another, or each is its own.
Zones zonesOf(const TopologicalMap& map, bool each = false) {
  DescriptorSequence recording{map.vocabulary, map.model, {}, DescriptorMatrix(map.vocabulary.size())};
  std::vector<int> groups;
  for (const MappedFrame& frame : map.frames) {
    recording.frames.push_back(frame);
    recording.descriptors.append(map.nodes.at(static_cast<std::size_t>(frame.node)).mean);
    groups.push_back(each ? frame.node : frame.node < 2 ? 1 : 0);
  }
  return describeZones(recording, groups);
}

TEST(MapPage, ZonesColorNodesAndAreNamedOnTheirCards) {
  const TopologicalMap map = sampleMap();
  const Zones zones = zonesOf(map);
  MapPage page{map};
  page.zones = &zones;
  const std::string html = renderMapPage(page);
  expectWellFormed(html);
  expectNothingFromOutside(html);
  EXPECT_EQ(count(html, "id=\"by-zones\" aria-pressed=\"true\""), 1U);
  EXPECT_EQ(count(html, "id=\"by-rooms\" aria-pressed=\"false\""), 1U);
  EXPECT_EQ(count(html, "<div id=\"legend-zones\">"), 1U);
  EXPECT_EQ(count(html, "In zone 1, "), 2U);
  EXPECT_EQ(count(html, "In zone 0, "), 3U);
  EXPECT_EQ(count(html, ": 100 % of its images"), 5U);
  const nlohmann::json data = dataOf(html);
  EXPECT_EQ(data["nodes"][0][4], data["nodes"][1][4]) << "one zone, one color";
  EXPECT_NE(data["nodes"][1][4], data["nodes"][2][4]);
  EXPECT_NE(data["nodes"][1][5], data["nodes"][2][5]) << "zones differ in shape, too";
  const TopologicalMap large = sampleMap({.nodes = 120});
  const Zones many = zonesOf(large, true);
  MapPage crowded{large};
  crowded.zones = &many;
  EXPECT_EQ(count(renderMapPage(crowded), "smaller zones</li>"), 1U) << "there are not so many colors";
  const Zones others = test::sampleZones();
  page.zones = &others;
  EXPECT_THROW(renderMapPage(page), Error) << "of another run";
}

TEST(MapPage, IsWrittenWholeOrNotAtAll) {
  const ScratchFolder scratch;
  const TopologicalMap map = sampleMap();
  writeMapPage(scratch / "report.html", {map});
  EXPECT_EQ(test::readFile(scratch / "report.html"), renderMapPage({map}));
  EXPECT_FALSE(std::filesystem::exists(scratch / "report.html.part"));
  EXPECT_THROW(writeMapPage(scratch / "missing" / "report.html", {map}), Error);
}

}  // namespace
}  // namespace estancia
