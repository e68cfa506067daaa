#include "estancia/report/zones_page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <regex>

#include "estancia/core/error.hpp"
#include "estancia/topology/store.hpp"
#include "sample_zones.hpp"
#include "support/html_checks.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::count;
using test::expectWellFormed;
using test::sampleZones;
using test::ScratchFolder;
using testing::HasSubstr;
using testing::Not;

void expectSound(const std::string& html) {
  expectWellFormed(html);
  test::expectNothingFromOutside(html);
  EXPECT_FALSE(std::regex_search(html, std::regex("(nan|inf)[ \"%,]")));
}

TEST(ZonesPage, ShowsImageStripTreeRoomsAndCards) {
  const Zones zones = sampleZones();
  ZonesPage page{zones};
  page.title = "A ring";
  page.measures = {{"v_measure", "V-measure", 0.94, 2, "Agreement with the rooms."}};
  const std::string html = renderZonesPage(page);
  expectSound(html);
  for (const char* text :
       {"A ring", "From above", "Over the run", "How images became zones", "Rooms and zones", "Zone by zone",
        "Agreement with the rooms.", "<dt>V-measure</dt><dd>0.94</dd>", "cut 0.5", "word3", " ± "})
    EXPECT_THAT(html, HasSubstr(text));
  EXPECT_EQ(count(html, "<article class=\"card\""), 5U);
  EXPECT_EQ(count(html, "<script"), 1U);
}

TEST(ZonesPage, EveryLinkLeadsToAPlaceOnThePage) {
  for (const std::size_t zones : {5U, 130U, 700U}) {
    const Zones sample =
        sampleZones({.zones = zones, .imagesPerZone = 4, .labels = 10, .dendrogram = zones == 5});
    const std::string html = renderZonesPage({sample});
    const std::regex link("href=\"#([^\"]*)\"");
    for (std::sregex_iterator it(html.begin(), html.end(), link), end; it != end; ++it)
      EXPECT_THAT(html, HasSubstr("id=\"" + std::string((*it)[1]) + "\"")) << (*it)[1];
  }
}

TEST(ZonesPage, WithoutPosesThereIsNoViewFromAbove) {
  const std::string html = renderZonesPage({sampleZones({.poses = false, .rooms = false})});
  expectSound(html);
  EXPECT_THAT(html, Not(HasSubstr("From above")));
  EXPECT_THAT(html, HasSubstr("No positions are known"));
  EXPECT_THAT(html, HasSubstr("Over the run"));
  EXPECT_THAT(html, Not(HasSubstr("Rooms and zones")));
}

TEST(ZonesPage, AbsurdPosesAreNoPlaces) {
  Zones zones = sampleZones();
  zones.frames[0].pose->x = std::numeric_limits<double>::quiet_NaN();
  zones.frames[1].pose->y = 1e300;
  expectSound(renderZonesPage({zones}));
  for (Frame& frame : zones.frames) frame.pose->z = std::numeric_limits<double>::infinity();
  const std::string html = renderZonesPage({zones});
  expectSound(html);
  EXPECT_THAT(html, Not(HasSubstr("From above")));
}

TEST(ZonesPage, ARobotThatStandsStillIsDrawn) {
  Zones zones = sampleZones({.zones = 3, .imagesPerZone = 400});
  for (Frame& frame : zones.frames) frame.pose = Pose{};
  expectSound(renderZonesPage({zones}));
}

TEST(ZonesPage, OneZoneAndOneImageArePages) {
  expectSound(renderZonesPage({sampleZones({.zones = 1})}));
  DescriptorSequence one{Vocabulary({"word"}), "", {Frame{}}, DescriptorMatrix(1)};
  one.descriptors.append(std::vector<float>{0});
  Progress silent;
  for (const bool posed : {false, true}) {
    if (posed) one.frames[0].pose = Pose{};
    const Zones zones = findZones(one, {}, silent);
    const std::string html = renderZonesPage({zones});
    expectSound(html);
    EXPECT_THAT(html, HasSubstr("<dt>zone</dt><dd>1</dd>"));
  }
  const Zones two = sampleZones({.zones = 2});
  ZonesPage folded{two};
  folded.cards = 1;
  EXPECT_THAT(renderZonesPage(folded), HasSubstr("<summary>1 smaller zone</summary>"));
}

TEST(ZonesPage, ZonesThatWereNotClusteredAtOnceHaveNoTree) {
  const std::string html = renderZonesPage({sampleZones({.dendrogram = false})});
  expectSound(html);
  EXPECT_THAT(html, Not(HasSubstr("How images became zones")));
  EXPECT_THAT(html, HasSubstr("the test says so"));
}

TEST(ZonesPage, HostileTextsStayTexts) {
  Zones zones = sampleZones({.dendrogram = false, .marker = test::hostileText});
  ZonesPage page{zones};
  page.title = page.date = test::hostileText;
  page.measures = {{test::hostileText, test::hostileText, std::nullopt, 2, test::hostileText}};
  const std::string html = renderZonesPage(page);
  expectSound(html);
  EXPECT_EQ(count(html, "<script"), 1U);
  EXPECT_THAT(html, Not(HasSubstr("<img src=x")));
  EXPECT_THAT(html, Not(HasSubstr("\xFF")));
}

TEST(ZonesPage, OnlyTheLargestOfManyZonesHaveAStyleOfTheirOwn) {
  const std::string html =
      renderZonesPage({sampleZones({.zones = 150, .imagesPerZone = 4, .labels = 10, .dendrogram = false})});
  expectSound(html);
  EXPECT_THAT(html, HasSubstr("45 zones still smaller"));
  EXPECT_THAT(html, HasSubstr("id=\"zone-149\""));
  EXPECT_THAT(html, Not(HasSubstr("data-zone=\"105\"")));
}

TEST(ZonesPage, FiftyThousandImagesStaySmall) {
  const Zones zones = sampleZones({.zones = 200, .imagesPerZone = 250, .labels = 60, .dendrogram = false});
  ASSERT_GE(zones.frames.size(), 50'000U);
  const std::string html = renderZonesPage({zones});
  expectSound(html);
  EXPECT_LT(html.size(), 3'000'000U);
}

TEST(ZonesPage, TheSameZonesGiveTheSameBytes) {
  const Zones zones = sampleZones();
  EXPECT_EQ(renderZonesPage({zones}), renderZonesPage({zones}));
}

TEST(ZonesPage, ImagesComeFromTheMapOfTheSameImages) {
  const Zones zones = sampleZones();
  ZonesPage page{zones};
  page.images.frames = {0, 1, 2, 30};
  page.images.read = [](std::size_t) { return std::vector<unsigned char>{0xFF, 0xD8, 0xFF, 0xE0, 1}; };
  const std::string html = renderZonesPage(page);
  expectSound(html);
  EXPECT_EQ(count(html, "<img "), 4U);
  EXPECT_EQ(count(html, " alt=\"What zone"), 4U);
}

TEST(ZonesPage, IsWrittenWholeOrNotAtAll) {
  const ScratchFolder scratch;
  const Zones zones = sampleZones();
  writeZonesPage(scratch / "zones.html", {zones});
  EXPECT_EQ(test::readFile(scratch / "zones.html"), renderZonesPage({zones}));
  EXPECT_THROW(writeZonesPage(scratch / "missing" / "zones.html", {zones}), Error);
}

}  // namespace
}  // namespace estancia
