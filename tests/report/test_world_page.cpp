// The page of a map with areas and objects.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <regex>
#include <string>

#include "estancia/core/error.hpp"
#include "estancia/figures/driven_path.hpp"
#include "estancia/figures/layout.hpp"
#include "estancia/report/map_page.hpp"
#include "estancia/world_query/route_world.hpp"
#include "support/errors.hpp"
#include "support/html_checks.hpp"
#include "support/sample_world.hpp"

namespace estancia {
namespace {

using test::count;
using test::FailsWith;
using test::Html;
using test::sampleWorld;
using testing::Contains;

const std::vector<unsigned char> objectJpeg{0xFF, 0xD8, 0xFF, 0xE0, 1, 2, 3};

WorldPage withObjectImages(const WorldMap& world) {
  return {.world = world, .image = [](int) { return objectJpeg; }};
}

std::string render(const WorldPage& above) {
  MapPage page{above.world.places};
  page.world = &above;
  return renderMapPage(page);
}

nlohmann::json worldDataOf(const std::string& html) {
  return nlohmann::json::parse(Html(html).texts("script").front())["world"];
}

void expectSoundPage(const std::string& html) {
  test::expectWellFormed(html);
  test::expectNothingFromOutside(html);
  EXPECT_FALSE(std::regex_search(html.substr(html.find("<body>"), html.find("<script") - html.find("<body>")),
                                 std::regex("(nan|inf)[ \"%,]")));
}

TEST(WorldPage, ShowsAreasWallsPathAndObjectsOnAPlan) {
  const WorldMap world = sampleWorld();
  const std::string html = render(withObjectImages(world));
  expectSoundPage(html);
  const Html page(html);
  EXPECT_EQ(page.count("svg.plan"), 2U) << "a wide and a narrow drawing";
  EXPECT_EQ(page.count("a.area"), 2U * 4);
  EXPECT_EQ(page.count("path.walls"), 2U);
  EXPECT_EQ(page.count("a.thing"), 2U * 6);
  EXPECT_THAT(page.texts("text.area-name"), Contains("kitchen"));
  EXPECT_THAT(page.texts("text.area-name"), Contains("Ana's \"room\""));
  EXPECT_THAT(page.texts("text.area-name"), Contains("bathtub"));
  EXPECT_EQ(page.count("g.start"), 2U);
  EXPECT_EQ(page.count("form"), 1U) << "one search for both drawings";
  EXPECT_THAT(page.texts("dt"), Contains("objects"));
}

TEST(WorldPage, AMapWithoutLayersHasTodaysPage) {
  WorldMap world = sampleWorld();
  world.plan.reset();
  world.areas.clear();
  world.objects.clear();
  world.areaOfFrame.assign(world.places.frames.size(), -1);
  EXPECT_EQ(render({world}), renderMapPage({world.places}));
}

TEST(WorldPage, ObjectsWithoutAPlanStandOnThePath) {
  WorldMap world = sampleWorld();
  world.plan.reset();
  world.areas.clear();
  for (WorldObject& object : world.objects) object.area = -1;
  const std::string html = render(withObjectImages(world));
  expectSoundPage(html);
  EXPECT_EQ(Html(html).count("a.thing"), 2U * 6);
  EXPECT_EQ(Html(html).count("path.walls"), 0U);
  EXPECT_THAT(Html(html).texts("h2"), Contains("Objects"));
}

TEST(WorldPage, ListsTheObjectsOfEachArea) {
  const Html page(render(withObjectImages(sampleWorld())));
  EXPECT_EQ(page.values("article.inside", "id"),
            (std::vector<std::string>{"area-0", "area-1", "area-2", "area-3"}));
  EXPECT_EQ(page.values("a.item", "id"), (std::vector<std::string>{"object-0", "object-1", "object-5",
                                                                   "object-4", "object-3", "object-2"}))
      << "named ones first, then the most probable";
}

TEST(WorldPage, TellsWhatIsRecognizedInNoAreaAndWhereTheRobotOnlyLooked) {
  WorldMap world = sampleWorld();
  world.areas[1].frames = 0;
  world.objects[1].known = KnownPose{"mug", 0.9, {}};
  world.objects[1].area = -1;
  const std::string html = render(withObjectImages(world));
  expectSoundPage(html);
  for (const char* fact : {"only looked into", "<small>recognized, 90 %</small>", "<h3>In no area</h3>"})
    EXPECT_EQ(count(html, fact), 1U) << fact;
}

TEST(WorldPage, NamesCannotBreakOut) {
  WorldMap world = sampleWorld();
  const std::string hostile = test::hostileText + "</script><script>alert(1)</script>";
  for (WorldArea& area : world.areas) area.givenName = area.name = hostile;
  for (WorldObject& object : world.objects) object.givenName = hostile;
  for (MappedFrame& frame : world.places.frames) frame.name = hostile;
  const std::string html = render(withObjectImages(world));
  expectSoundPage(html);
  EXPECT_EQ(count(html, "<script"), 2U) << "the data and the one script";
  EXPECT_EQ(count(html, "<img src=x"), 0U);
}

TEST(WorldPage, WithoutAnImageAnObjectIsADotInItsColor) {
  const WorldMap world = sampleWorld();
  const Html page(render({world}));
  EXPECT_EQ(page.count("symbol"), 0U);
  EXPECT_EQ(page.count("use"), 0U);
  EXPECT_EQ(page.count("circle.dot"), 2U * 6);
  EXPECT_EQ(page.values("circle.dot", "fill").front(), "#c86432");
}

TEST(WorldPage, ImagesThatFindNoRoomAreLeftOutAndCounted) {
  const WorldMap world = sampleWorld();
  WorldPage above = withObjectImages(world);
  above.bytes = 2 * objectJpeg.size();
  const Html page(render(above));
  EXPECT_EQ(page.values("symbol", "id"), (std::vector<std::string>{"image-0", "image-1"}))
      << "most views first";
  EXPECT_EQ(page.count("p.note"), Html(render(withObjectImages(world))).count("p.note") + 1);
}

TEST(WorldPage, TheWayOfAnObjectIsThatOfRoute) {
  const WorldMap world = sampleWorld();
  const nlohmann::json data = worldDataOf(render({world}));
  EXPECT_EQ(data["from"], 0);
  for (const WorldObject& object : world.objects) {
    const auto& json = data["objects"][static_cast<std::size_t>(object.id)];
    const std::string name = object.id == 3 ? "umbrella" : object.id == 4 ? test::hostileName : "";
    if (name.empty()) continue;
    const WorldRoute route = routeInWorld(world, 0, name);
    ASSERT_EQ(route.object->object, object.id);
    ASSERT_TRUE(route.driven);
    EXPECT_NEAR(json["length"].get<double>(), route.driven->length, 0.006);
    EXPECT_NEAR(json["pose"][0].get<double>(), route.pose->x, 0.006);
    EXPECT_NEAR(json["pose"][1].get<double>(), route.pose->y, 0.006);
    EXPECT_NEAR(json["pose"][2].get<double>(), route.pose->yaw, 1e-4);
    EXPECT_NEAR(json["way"].back()[0].get<double>(), route.pose->x, 0.06);
  }
  const nlohmann::json area = data["areas"][2];
  const WorldRoute route = routeInWorld(world, 0, "corridor");
  EXPECT_NEAR(area["length"].get<double>(), route.driven->length, 0.006);
  EXPECT_NEAR(area["way"].back()[0].get<double>(), route.driven->points.back().x, 0.06);
}

TEST(WorldPage, WaysStartWhereItIsAsked) {
  const WorldMap world = sampleWorld();
  WorldPage above{.world = world, .from = 3};
  EXPECT_EQ(worldDataOf(render(above))["from"], 3);
  above.from = 99;
  EXPECT_THAT([&] { render(above); }, FailsWith(ErrorCode::unknownName));
}

TEST(WorldPage, AnObjectBeyondTheEarthIsListedButNotDrawn) {
  WorldMap world = sampleWorld();
  world.objects[2].center.x = 1e300;
  world.places.frames[1].pose->y = std::nan("");
  const std::string html = render(withObjectImages(world));
  expectSoundPage(html);
  EXPECT_EQ(Html(html).count("a.thing"), 2U * 5);
  EXPECT_EQ(Html(html).count("a.item"), 6U);
}

TEST(WorldPage, NamesOfAreasStayWithinThem) {
  WorldMap world = sampleWorld();
  world.areas[1].givenName = "where everybody washes hands";
  world.plan->areaOf.setTo(-1, world.plan->areaOf == 2);
  world.plan->areaOf(cv::Rect(42, 42, 2, 30)) = 2;
  const auto names = Html(render({world})).texts("text.area-name");
  EXPECT_THAT(names, Contains("kitchen"));
  EXPECT_THAT(names, Contains("2")) << "20 cm wide";
  EXPECT_THAT(names, testing::Not(Contains("where everybody washes hands")));
  EXPECT_THAT(names, Contains(testing::StartsWith("where")));
}

}  // namespace
}  // namespace estancia
