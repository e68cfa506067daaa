#include "estancia/report/map_page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <regex>

#include "estancia/core/error.hpp"
#include "sample_map.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::sampleMap;
using test::ScratchFolder;
using testing::HasSubstr;
using testing::Not;

const std::vector<unsigned char> jpeg{0xFF, 0xD8, 0xFF, 0xE0, 1, 2, 3};

MapPage withPictures(const TopologicalMap& map, std::size_t bytes = 7) {
  MapPage page{map};
  for (std::size_t i = 0; i < map.frames.size(); ++i) page.pictures.frames.push_back(i);
  page.pictures.read = [bytes](std::size_t) {
    std::vector<unsigned char> picture = jpeg;
    picture.resize(bytes);
    return picture;
  };
  return page;
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

/// The elements of the body are properly nested: nothing that came from outside has opened or closed one.
void expectWellFormed(const std::string& html) {
  const std::string body = html.substr(html.find("<body>"));
  std::vector<std::string> open{"html"};
  for (std::size_t at = body.find('<'); at != std::string::npos; at = body.find('<', at + 1)) {
    const std::size_t end = body.find('>', at);
    ASSERT_NE(end, std::string::npos);
    const std::string tag = body.substr(at + 1, end - at - 1);
    const std::string name = tag.substr(0, tag.find_first_of(" />", 1));
    if (tag[0] == '/') {
      ASSERT_FALSE(open.empty());
      ASSERT_EQ(tag.substr(1), open.back()) << body.substr(at > 200 ? at - 200 : 0, 300);
      open.pop_back();
    } else if (tag.back() != '/') {
      open.push_back(name);
      if (name == "script") at = body.find("</script", at) - 1;
    }
  }
  EXPECT_TRUE(open.empty()) << open.back();
}

nlohmann::json dataOf(const std::string& html) {
  const std::string start = "id=\"data\">";
  const std::size_t from = html.find(start) + start.size();
  return nlohmann::json::parse(html.substr(from, html.find("</script>", from) - from));
}

TEST(MapPage, NeedsNothingFromOutside) {
  const TopologicalMap map = sampleMap();
  const std::string html = renderMapPage(withPictures(map));
  EXPECT_FALSE(std::regex_search(html, std::regex("https?:|//[a-z]+\\.|@import|url\\(|<link|<iframe")));
  const std::regex reference("(src|href|action|data)=\"([^\"]{0,12})");
  for (std::sregex_iterator it(html.begin(), html.end(), reference), end; it != end; ++it) {
    const std::string target = (*it)[2];
    EXPECT_TRUE(target.starts_with("#") || target.starts_with("data:image/")) << target;
  }
  EXPECT_THAT(html, HasSubstr("default-src 'none'"));
}

TEST(MapPage, ShowsNodesPicturesDecisionsAndMeasures) {
  const TopologicalMap map = sampleMap();
  MapPage page = withPictures(map);
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

TEST(MapPage, EveryPictureHasAnAlternativeText) {
  const TopologicalMap map = sampleMap();
  const std::string html = renderMapPage(withPictures(map));
  EXPECT_EQ(count(html, "<img "), count(html, " alt=\"What node"));
}

TEST(MapPage, HostileTextsStayTexts) {
  test::SampleOptions options;
  options.marker = "</script><script>alert(1)</script><img src=x onerror='a'>\"'&\xFF]]>--><!--";
  const TopologicalMap map = sampleMap(options);
  MapPage page = withPictures(map);
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
  EXPECT_EQ(renderMapPage(withPictures(map)), renderMapPage(withPictures(map)));
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

TEST(MapPage, OneNodeWithoutPosesRoomsOrPicturesIsAPage) {
  const TopologicalMap map = sampleMap({.nodes = 1, .poses = false, .rooms = false});
  const std::string html = renderMapPage({map});
  expectWellFormed(html);
  EXPECT_THAT(html, HasSubstr("No poses are known"));
  EXPECT_THAT(html, Not(HasSubstr("Colour by room")));
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
  const std::string html = renderMapPage(withPictures(map, 12'000));
  expectWellFormed(html);
  EXPECT_LT(html.size(), 6'000'000U);
  EXPECT_THAT(html, HasSubstr("60 largest of 1000 nodes"));
  EXPECT_THAT(html, HasSubstr("left out to keep this page small"));
  EXPECT_THAT(html, HasSubstr("leaves out probabilities below"));
  EXPECT_EQ(count(html, "<article"), 1000U);
}

TEST(MapPage, EveryNodeHasAPictureBeforeAnyHasTwo) {
  const TopologicalMap map = sampleMap();
  MapPage page = withPictures(map, 1000);
  page.pictures.bytes = 5500;
  const std::string html = renderMapPage(page);
  EXPECT_EQ(count(html, "<img "), 5U);
  EXPECT_EQ(count(html, "class=\"pictures p1\""), 5U);
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
