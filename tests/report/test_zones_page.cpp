// SPDX-License-Identifier: Apache-2.0
#include "estancia/report/zones_page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <regex>

#include "estancia/core/error.hpp"
#include "estancia/files/home_plan.hpp"
#include "estancia/map_file/store.hpp"
#include "estancia/words/label_concepts.hpp"
#include "sample_zones.hpp"
#include "support/errors.hpp"
#include "support/html_checks.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::count;
using test::expectWellFormed;
using test::sampleZones;
using test::ScratchFolder;

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
  EXPECT_EQ(count(html, "A ring"), 2U) << "title and heading";
  for (const char* element :
       {"<figure class=\"figure image\">", "<figure class=\"figure when\">",
        "<figure class=\"figure merging\">", "<section id=\"rooms\">", "<section id=\"places\">",
        "<td>Agreement with the rooms.</td>", "<dt>V-measure</dt><dd>0.94</dd>"})
    EXPECT_EQ(count(html, element), 1U) << element;
  EXPECT_EQ(count(html, ">cut 0.5</text>"), 2U) << "a wide and a narrow drawing";
  EXPECT_EQ(count(html, "<ol class=\"labels spread\">"), 5U);
  EXPECT_EQ(count(html, "<article class=\"card\""), 5U);
  EXPECT_EQ(count(html, "<script"), 1U);
}

TEST(ZonesPage, FamiliarWordsStandForSeveralLabels) {
  Zones zones = sampleZones({.dendrogram = false});
  zones.zones[0].mean[0] = 0.4F;
  zones.zones[0].mean[1] = 0.3F;
  ZonesPage page{zones};
  EXPECT_EQ(count(renderZonesPage(page), ">thing<"), 0U);
  const LabelConcepts concepts{{"thing", 1, {0, 1}, {0, 1}}};
  page.concepts = &concepts;
  const std::string html = renderZonesPage(page);
  expectSound(html);
  EXPECT_EQ(count(html, "title=\"word0 0.4, word1 0.3\">thing</span>"), 1U);
  EXPECT_EQ(count(html, "<span class=\"p\">0.7</span>"), 1U) << "the deviation of the sum is not known";
}

TEST(ZonesPage, CardsNameRoomsThatArePredictedAndTheFourMostFrequentTrueOnes) {
  Zones zones = sampleZones({.zones = 1, .imagesPerZone = 20, .dendrogram = false});
  for (std::size_t i = 0; i < zones.frames.size(); ++i) zones.frames[i].room = std::to_string(i % 7);
  zones.zones[0].predicted = {{"kitchen", 0.75}, {"bath", 0.25}};
  const std::string html = renderZonesPage({zones});
  expectSound(html);
  EXPECT_EQ(count(html, "Taken for kitchen 75 %"), 1U);
  EXPECT_EQ(count(html, "Rooms: 0 3, 1 3, 2 3, 3 3 and 3 more"), 1U);
  const Zones none{Vocabulary({"word"})};
  const std::string empty = renderZonesPage({none});
  expectSound(empty);
  EXPECT_EQ(count(empty, "<section"), 0U);
}

TEST(ZonesPage, EveryLinkLeadsToAPlaceOnThePage) {
  for (const std::size_t zones : {5U, 130U, 700U}) {
    const Zones sample =
        sampleZones({.zones = zones, .imagesPerZone = 4, .labels = 10, .dendrogram = zones == 5});
    const std::string html = renderZonesPage({sample});
    const std::regex link("href=\"#([^\"]*)\"");
    for (std::sregex_iterator it(html.begin(), html.end(), link), end; it != end; ++it)
      EXPECT_EQ(count(html, "id=\"" + std::string((*it)[1]) + "\""), 1U) << (*it)[1];
  }
}

TEST(ZonesPage, AbsurdPosesAreNoPlaces) {
  Zones zones = sampleZones();
  zones.frames[0].pose->x = std::numeric_limits<double>::quiet_NaN();
  zones.frames[1].pose->y = 1e300;
  expectSound(renderZonesPage({zones}));
  for (Frame& frame : zones.frames) frame.pose = Pose{};
  expectSound(renderZonesPage({zones}));
  for (Frame& frame : zones.frames) frame.pose->z = std::numeric_limits<double>::infinity();
  const std::string html = renderZonesPage({zones});
  expectSound(html);
  EXPECT_EQ(count(html, "<figure class=\"figure image\">"), 0U);
}

TEST(ZonesPage, FloorPlansAreDrawnUnderTheZones) {
  Zones zones = sampleZones({.zones = 3});
  ZonesPage page{zones};
  const auto home = std::make_shared<io::HomePlan>();
  home->rooms = {{"hall", {{-500, -500}, {500, -500}, {500, 500}, {-500, 500}}}};
  page.floorPlan = FloorPlan{{}, -500, -500, 500, 500, home};
  const std::string html = renderZonesPage(page);
  expectSound(html);
  EXPECT_EQ(count(html, "<path class=\"wall\""), 2U) << "wide and narrow";
  EXPECT_EQ(count(html, ">hall</text>"), 2U);
  home->rooms[0].polygon = {{900, 900}, {901, 900}, {901, 901}};
  EXPECT_THAT([&] { renderZonesPage(page); }, test::FailsWith(ErrorCode::mismatch)) << "another origin";
  for (Frame& frame : zones.frames) frame.pose.reset();
  EXPECT_THAT([&] { renderZonesPage(page); }, test::FailsWith(ErrorCode::insufficientData));
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
    EXPECT_EQ(count(html, "<dt>zone</dt><dd>1</dd>"), 1U);
  }
  const Zones two = sampleZones({.zones = 2});
  ZonesPage folded{two};
  folded.cards = 1;
  EXPECT_EQ(count(renderZonesPage(folded), "<article class=\"row\""), 1U);
}

TEST(ZonesPage, ZonesThatWereNotClusteredAtOnceHaveNoTree) {
  const std::string html = renderZonesPage({sampleZones({.dendrogram = false})});
  expectSound(html);
  EXPECT_EQ(count(html, "<figure class=\"figure merging\">"), 0U);
  EXPECT_EQ(count(html, "the test says so"), 1U);
}

TEST(ZonesPage, HostileTextsStayTexts) {
  Zones zones = sampleZones({.dendrogram = false, .marker = test::hostileText});
  ZonesPage page{zones};
  page.title = page.date = test::hostileText;
  page.measures = {{test::hostileText, test::hostileText, std::nullopt, 2, test::hostileText}};
  const std::string html = renderZonesPage(page);
  expectSound(html);
  EXPECT_EQ(count(html, "<script"), 1U);
  EXPECT_EQ(count(html, "<img src=x"), 0U);
  EXPECT_EQ(count(html, "\xFF"), 0U);
}

TEST(ZonesPage, FiftyThousandImagesStaySmall) {
  const Zones zones = sampleZones({.zones = 200, .imagesPerZone = 250, .labels = 60, .dendrogram = false});
  ASSERT_GE(zones.frames.size(), 50'000U);
  const std::string html = renderZonesPage({zones});
  expectSound(html);
  EXPECT_LT(html.size(), 3'000'000U);
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
  const ScratchFolder scratch;
  MapStore map = MapStore::create(scratch / "home.estancia", {zones.vocabulary, "model", "{}"});
  for (const std::size_t i : {7U, 3U}) {
    MappedFrame frame{zones.frames[i]};
    frame.number = i == 7 ? 0 : 1;
    map.addFrame(frame, LexicalDescriptor(zones.vocabulary.size(), 0.1F));
    map.putImage(frame.number, {0xFF, 0xD8, static_cast<unsigned char>(i)});
  }
  map.putNode(
      {0, 2, std::vector<float>(zones.vocabulary.size()), std::vector<float>(zones.vocabulary.size())}, "");
  const PageImages found = imagesOf(map, zones.frames);
  EXPECT_EQ(found.frames, (std::vector<std::size_t>{3, 7})) << "by their names";
  EXPECT_EQ(found.read(7).back(), 7);
}

TEST(ZonesPage, IsWrittenWholeOrNotAtAll) {
  const ScratchFolder scratch;
  const Zones zones = sampleZones();
  writeZonesPage(scratch / "zones.html", {zones});
  EXPECT_EQ(test::readFile(scratch / "zones.html"), renderZonesPage({zones}));
  EXPECT_THROW(writeZonesPage(scratch / "missing" / "zones.html", {zones}), Error);
}

TEST(ZonesPage, OnlyTheLargestOfManyZonesHaveAStyleOfTheirOwn) {
  const std::string html =
      renderZonesPage({sampleZones({.zones = 150, .imagesPerZone = 4, .labels = 10, .dendrogram = false})});
  expectSound(html);
  EXPECT_EQ(count(html, "<p class=\"rest\">"), 1U);
  EXPECT_EQ(count(html, "id=\"zone-149\""), 1U);
  EXPECT_GT(count(html, "data-zone=\"104\""), 0U);
  EXPECT_EQ(count(html, "data-zone=\"105\""), 0U);
}

TEST(ZonesPage, WithoutPosesThereIsNoViewFromAbove) {
  const std::string html = renderZonesPage({sampleZones({.poses = false, .rooms = false})});
  expectSound(html);
  EXPECT_EQ(count(html, "<figure class=\"figure image\">"), 0U);
  EXPECT_EQ(count(html, "<figure class=\"figure when\">"), 1U);
  EXPECT_EQ(count(html, "<section id=\"rooms\">"), 0U);
}

}  // namespace
}  // namespace estancia
