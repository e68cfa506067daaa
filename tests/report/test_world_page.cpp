// The page of a map with areas and objects.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <string>

#include "estancia/core/error.hpp"
#include "estancia/figures/plan_shapes.hpp"
#include "estancia/figures/thumbnails.hpp"
#include "estancia/report/map_page.hpp"
#include "estancia/report/world_view.hpp"
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
using testing::ElementsAre;
using testing::HasSubstr;

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

TEST(AreaColor, DiffersForManyAreas) {
  std::set<std::string> colors;
  for (int area = 0; area < 21; ++area) colors.insert(report::areaColor(area).hex());
  EXPECT_EQ(colors.size(), 21U);
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

TEST(WorldPage, TheSearchFormHasAnExampleOnlyWhereAWordFindsAnObject) {
  WorldMap world = sampleWorld();
  EXPECT_THAT(render(withObjectImages(world)), HasSubstr("placeholder=\"e.g. "));
  for (WorldObject& object : world.objects) object.words.clear();
  EXPECT_EQ(count(render(withObjectImages(world)), "placeholder"), 0U);
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
  const std::vector<std::string> items = page.texts("a.item");
  EXPECT_THAT(items[0],
              testing::AllOf(HasSubstr("dining table"), HasSubstr("80 %"), HasSubstr("on the floor")));
  EXPECT_THAT(items[1], HasSubstr("on the dining table"));
  EXPECT_THAT(items[3], HasSubstr("named by people"));
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

TEST(WorldPage, EachImageIsInThePageOnce) {
  const std::string html = render(withObjectImages(sampleWorld()));
  EXPECT_EQ(Html(html).count("symbol"), 6U);
  EXPECT_EQ(count(html, "data:image/jpeg"), 6U);
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
  EXPECT_THAT(page.texts("p.note"), Contains(HasSubstr("4 images left out")));
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
}

TEST(WorldPage, TheWayToAnAreaIsThatOfRoute) {
  const WorldMap world = sampleWorld();
  const nlohmann::json area = worldDataOf(render({world}))["areas"][2];
  const WorldRoute route = routeInWorld(world, 0, "corridor");
  EXPECT_NEAR(area["length"].get<double>(), route.driven->length, 0.006);
  EXPECT_NEAR(area["way"].back()[0].get<double>(), route.driven->points.back().x, 0.06);
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

TEST(WorldPage, WaysStartWhereItIsAsked) {
  const WorldMap world = sampleWorld();
  WorldPage above{.world = world, .from = 3};
  EXPECT_EQ(worldDataOf(render(above))["from"], 3);
  above.from = 99;
  EXPECT_THAT([&] { render(above); }, FailsWith(ErrorCode::unknownName, "99"));
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

TEST(PlanShapes, SurroundTheCellsToHalfACell) {
  const AreaPlan plan = test::samplePlan();
  const report::PlanShapes shapes = report::shapesOf(plan);
  ASSERT_EQ(shapes.areas.size(), 4U);
  ASSERT_EQ(shapes.areas[0].size(), 1U);
  double left = 1e9, right = -1e9;
  for (const report::Point& point : shapes.areas[0][0]) {
    left = std::min(left, point.x);
    right = std::max(right, point.x);
  }
  EXPECT_NEAR(left, 0, 0.05);
  EXPECT_NEAR(right, 4, 0.15) << "to the wall's cells, and into the door";
  EXPECT_FALSE(shapes.walls.empty());
}

TEST(PlanShapes, AnAreaAroundAPillarHasAHole) {
  AreaPlan plan = test::samplePlan();
  plan.areaOf(cv::Rect(10, 10, 5, 5)) = -1;
  EXPECT_EQ(report::shapesOf(plan).areas[0].size(), 2U);
}

TEST(Thumbnails, DoNotHideEachOtherNorWhatIsBlocked) {
  const report::Box frame{0, 0, 200, 200}, name{20, 20, 60, 16};
  report::Thumbnails room(frame, 30);
  room.block(name);
  std::vector<report::Box> taken;
  for (double x = 5; x < 200; x += 10)
    for (double y = 5; y < 200; y += 10)
      if (const auto box = room.take({x, y})) {
        EXPECT_TRUE(box->inside(frame));
        EXPECT_FALSE(box->overlaps(name));
        for (const report::Box& other : taken) EXPECT_FALSE(box->overlaps(other));
        taken.push_back(*box);
      }
  EXPECT_GT(taken.size(), 15U);
  EXPECT_LT(taken.size(), 400U) << "the others are dots";
}

}  // namespace
}  // namespace estancia
