#include "estancia/report/map_page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <regex>

#include "estancia/core/error.hpp"
#include "sample_map.hpp"
#include "sample_zones.hpp"
#include "support/html_checks.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::count;
using test::expectNothingFromOutside;
using test::expectWellFormed;
using test::sampleMap;
using test::ScratchFolder;
using testing::HasSubstr;
using testing::Not;

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

TEST(MapPage, NeedsNothingFromOutside) {
  const TopologicalMap map = sampleMap();
  const std::string html = renderMapPage(withImages(map));
  expectNothingFromOutside(html);
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
  EXPECT_THAT(html, HasSubstr("Decisions over time"));
  EXPECT_THAT(html, HasSubstr("Agreement with the rooms."));
  EXPECT_THAT(html, HasSubstr("corridor"));
  EXPECT_THAT(html, HasSubstr("room 3"));
  expectWellFormed(html);
}

TEST(MapPage, EveryImageHasAnAlternativeText) {
  const TopologicalMap map = sampleMap();
  const std::string html = renderMapPage(withImages(map));
  EXPECT_EQ(count(html, "<img "), count(html, " alt=\"What node"));
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
  EXPECT_THAT(html, Not(HasSubstr("<img src=x")));
  EXPECT_THAT(html, Not(HasSubstr("\xFF")));
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
  EXPECT_THAT(html, HasSubstr("no nodes yet"));
}

TEST(MapPage, OneNodeWithoutPosesRoomsOrImagesIsAPage) {
  const TopologicalMap map = sampleMap({.nodes = 1, .poses = false, .rooms = false});
  const std::string html = renderMapPage({map});
  expectWellFormed(html);
  EXPECT_THAT(html, HasSubstr("No poses are known"));
  EXPECT_THAT(html, Not(HasSubstr("Color by room")));
  EXPECT_THAT(html, Not(HasSubstr("<img ")));
  EXPECT_THAT(html, Not(HasSubstr("nan")));
}

TEST(MapPage, ARobotThatStandsStillIsDrawn) {
  TopologicalMap map = sampleMap();
  for (MappedFrame& frame : map.frames) frame.pose = Pose{};
  const std::string html = renderMapPage({map});
  expectWellFormed(html);
  EXPECT_FALSE(std::regex_search(html, std::regex("(nan|inf)[ \"]")));
}

TEST(MapPage, StartsAsTheHeatMapOfAGivenLabel) {
  const TopologicalMap map = sampleMap();
  MapPage page{map};
  page.label = 7;
  const std::string html = renderMapPage(page);
  EXPECT_THAT(html, HasSubstr("Where is “word7”?"));
  EXPECT_THAT(html, HasSubstr("id=\"legend-rooms\" hidden"));
  page.label = 40;
  EXPECT_THROW(renderMapPage(page), Error);
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
  EXPECT_THAT(html, HasSubstr("60 largest of 1000 nodes"));
  EXPECT_THAT(html, HasSubstr("left out to keep this page small"));
  EXPECT_THAT(html, HasSubstr("leaves out probabilities below"));
  EXPECT_EQ(count(html, "<article"), 1000U);
  MapPage folded{map};
  folded.cards = 999;
  EXPECT_THAT(renderMapPage(folded), HasSubstr("<summary>The 1 smaller node</summary>"));
}

TEST(MapPage, EveryNodeHasAImageBeforeAnyHasTwo) {
  const TopologicalMap map = sampleMap();
  MapPage page = withImages(map, 1000);
  page.images.bytes = 5500;
  const std::string html = renderMapPage(page);
  EXPECT_EQ(count(html, "<img "), 5U);
  EXPECT_EQ(count(html, "class=\"images p1\""), 5U);
}

TEST(MapPage, FloorPlanIsCheckedAndEmbedded) {
  const ScratchFolder scratch;
  test::writeFile(scratch / "plan.jpg", std::string(jpeg.begin(), jpeg.end()));
  test::writeFile(scratch / "plan.svg", "<svg/>");
  EXPECT_THROW(readFloorPlan(scratch / "none.jpg", {0, 0, 1, 1}), Error);
  EXPECT_THROW(readFloorPlan(scratch / "plan.svg", {0, 0, 1, 1}), Error);
  EXPECT_THROW(readFloorPlan(scratch / "plan.jpg", {0, 0, 0, 1}), Error);
  EXPECT_THROW(readFloorPlan(scratch / "plan.jpg", {0, 0, NAN, 1}), Error);

  const TopologicalMap map = sampleMap(), unposed = sampleMap({.poses = false});
  MapPage page{map};
  page.floorPlan = readFloorPlan(scratch / "plan.jpg", {-10, -10, 10, 10});
  EXPECT_THAT(renderMapPage(page), HasSubstr("<image class=\"plan\""));
  MapPage impossible{unposed};
  impossible.floorPlan = page.floorPlan;
  EXPECT_THROW(renderMapPage(impossible), Error);
}

/// Zones of the frames of a map: its nodes 0 and 1 are one zone, all others another.
Zones zonesOf(const TopologicalMap& map) {
  DescriptorSequence recording{map.vocabulary, map.model, {}, DescriptorMatrix(map.vocabulary.size())};
  std::vector<int> groups;
  for (const MappedFrame& frame : map.frames) {
    recording.frames.push_back(frame);
    recording.descriptors.append(map.nodes.at(static_cast<std::size_t>(frame.node)).mean);
    groups.push_back(frame.node < 2 ? 1 : 0);
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
  EXPECT_THAT(html, HasSubstr("id=\"by-zones\" aria-pressed=\"true\""));
  EXPECT_THAT(html, HasSubstr("id=\"by-rooms\" aria-pressed=\"false\""));
  EXPECT_THAT(html, HasSubstr("<div id=\"legend-zones\">"));
  EXPECT_EQ(count(html, "In zone 1, "), 2U);
  EXPECT_EQ(count(html, "In zone 0, "), 3U);
  EXPECT_EQ(count(html, ": 100 % of its images"), 5U);
  const nlohmann::json data = dataOf(html);
  EXPECT_EQ(data["nodes"][0][4], data["nodes"][1][4]) << "one zone, one color";
  EXPECT_NE(data["nodes"][1][4], data["nodes"][2][4]);
  EXPECT_NE(data["nodes"][1][5], data["nodes"][2][5]) << "zones differ in shape, too";
}

/// The badge of a node's card: color and text.
std::string badgeOf(const std::string& html, int node) {
  const std::size_t card = html.find("<article class=\"card\" id=\"node-" + std::to_string(node) + "\"");
  const std::size_t from = html.find("<svg class=\"badge\"", card);
  return html.substr(from, html.find("</svg>", from) - from);
}

TEST(MapPage, BadgesOfCardsHaveTheColorsOfTheMap) {
  const TopologicalMap map = sampleMap();
  const Zones zones = zonesOf(map);
  MapPage page{map};
  page.zones = &zones;
  const auto expectColumn = [&page](std::size_t column) {
    const std::string html = renderMapPage(page);
    const nlohmann::json data = dataOf(html);
    for (int n = 0; n < 5; ++n) {
      const nlohmann::json& node = data["nodes"].at(static_cast<std::size_t>(n));
      const std::string badge = badgeOf(html, n);
      EXPECT_THAT(badge, HasSubstr(node.at(column).get<std::string>())) << n;
      EXPECT_THAT(badge, HasSubstr(data["shapes"].at(node.at(column + 1).get<std::size_t>()))) << n;
      EXPECT_THAT(html, HasSubstr("id=\"node-" + std::to_string(n) + "\" data-node=\"" + std::to_string(n)))
          << "the script finds it";
    }
  };
  expectColumn(4);
  page.label = 0;
  expectColumn(2);  // a heat map keeps the shapes of the rooms
}

TEST(MapPage, ZonesOfAnotherRunAreRefused) {
  const TopologicalMap map = sampleMap();
  const Zones zones = test::sampleZones();
  MapPage page{map};
  page.zones = &zones;
  EXPECT_THROW(renderMapPage(page), Error);
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
