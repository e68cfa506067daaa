// Ways to areas and objects, around what is to be avoided.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/world_query/route_world.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>

#include "estancia/world_query/driven_way.hpp"
#include "estancia/world_query/world_json.hpp"
#include "support/errors.hpp"
#include "support/sample_world.hpp"

namespace estancia {
namespace {

using Json = nlohmann::ordered_json;
using test::FailsWith;
using test::sampleRoundTrip;
using test::sampleWorld;
using testing::ElementsAre;

bool always(std::size_t) {
  return true;
}

void closeDoors(WorldMap& world) {
  world.plan->walls.colRange(40, 41) = 255;
  world.plan->walls.colRange(60, 61) = 255;
}

TEST(ViewPoses, AreTheNearestThatHadAllOfItInView) {
  const WorldMap world = sampleWorld();
  const ViewPoses poses(world, 20);
  const auto mug = poses.find(world.objects[1], always);
  ASSERT_TRUE(mug);
  EXPECT_EQ(mug->frame, 1U);
  EXPECT_NEAR(mug->x, 2, 1e-9);
  EXPECT_NEAR(mug->y, 4, 1e-9);
  EXPECT_NEAR(mug->yaw, std::atan2(2.4, 0.2), 1e-9);
  EXPECT_NEAR(mug->distance, std::hypot(2.4, 0.2), 1e-9);
  EXPECT_EQ(poses.find(world.objects[0], always)->frame, 7U)
      << "the table needs more distance: through the door";
  EXPECT_EQ(ViewPoses(world, 30).find(world.objects[0], always)->frame, 1U);

  WorldObject behind = world.objects[1];
  behind.center = {2, 0.2, 0.5};  // behind all frames: turn to it where the best one was taken
  const auto turned = poses.find(behind, always);
  ASSERT_TRUE(turned);
  EXPECT_EQ(turned->frame, 1U);
  EXPECT_NEAR(turned->yaw, -std::numbers::pi / 2, 1e-9);
}

TEST(ViewPoses, LookThroughDoorsButNotThroughWalls) {
  WorldMap world = sampleWorld();
  world.objects[1].bestFrame = 0;
  const auto notFromTheKitchen = [](std::size_t frame) { return frame != 1 && frame != 0; };
  EXPECT_EQ(ViewPoses(world, 20).find(world.objects[1], notFromTheKitchen)->frame, 7U);
  closeDoors(world);
  EXPECT_FALSE(ViewPoses(world, 20).find(world.objects[1], notFromTheKitchen));
  world.plan.reset();
  EXPECT_EQ(ViewPoses(world, 20).find(world.objects[1], notFromTheKitchen)->frame, 7U);
  world.places.frames[7].pose.reset();
  EXPECT_NE(ViewPoses(world, 20).find(world.objects[1], notFromTheKitchen)->frame, 7U);
}

TEST(RouteInWorld, EndsInThePlaceOfTheFrameThatFacesTheObject) {
  const WorldMap world = sampleWorld();
  const WorldRoute found = routeInWorld(world, 3, "coffee mug");
  ASSERT_TRUE(found.object && found.pose);
  EXPECT_EQ(found.object->object, 1);
  EXPECT_THAT(found.route.nodes, ElementsAre(3, 1, 0));
  EXPECT_EQ(world.places.frames[found.pose->frame].node, 0);
  EXPECT_THAT(found.areas, ElementsAre(3, 1, 0));
  EXPECT_EQ(routeInWorld(world, 0, test::hostileName).object->object, 4);
}

TEST(RouteInWorld, TakesTheCheapestOfEquallyProbableObjects) {
  WorldMap world = sampleWorld();
  world.objects[5].words = {{"umbrella", 0.68F}};  // in the bathroom, nearer than the 70 % in the living room
  EXPECT_EQ(routeInWorld(world, 0, "umbrella").object->object, 5);
  EXPECT_EQ(routeInWorld(world, 0, "umbrella", {.avoid = {"3", "bathtub"}}).object->object, 5);
  RouteOptions strict;
  strict.tolerance = 0;
  EXPECT_EQ(routeInWorld(world, 0, "umbrella", {}, strict).object->object, 3);
  RouteOptions oneWay;
  oneWay.bidirectional = false;
  world.places.transitions.resize(1);
  EXPECT_EQ(routeInWorld(world, 0, "umbrella", {}, strict).object->object, 5) << "the rest is out of reach";
}

TEST(RouteInWorld, PrefersAPlaceToAnObjectThatIsHardlyMeant) {
  WorldMap world = sampleWorld();
  EXPECT_EQ(routeInWorld(world, 0, "mug").object->object, 2) << "0.3, above 0.2 of the best place";
  world.objects[2].words[1].probability = world.objects[1].words[1].probability = 0.15F;
  const WorldRoute found = routeInWorld(world, 0, "mug");
  EXPECT_FALSE(found.object);
  ASSERT_TRUE(found.place);
  EXPECT_EQ(found.place->node, routeToWords(world.places, 0, "mug").goal.node);
  EXPECT_EQ(toJson("mug", found, world)["label"], "cup, mug");
}

TEST(RouteInWorld, EndsInAnAreaOfThatName) {
  WorldMap world = sampleRoundTrip();
  const WorldRoute found = routeInWorld(world, 0, "corridor");
  EXPECT_EQ(found.area, 2);
  EXPECT_THAT(found.route.nodes, ElementsAre(0, 2));
  world.areas.push_back({{.id = 4, .name = "mop"}, "closet"});
  EXPECT_THAT([&] { routeInWorld(world, 0, "closet"); }, FailsWith(ErrorCode::noAnswer));
  world.areaOfFrame[7] = 4;
  EXPECT_THAT(routeInWorld(world, 0, "closet").route.nodes, ElementsAre(0, 2));
  world.areaOfFrame[0] = 4;  // one of three frames of place 0
  world.areaOfFrame[7] = 2;
  EXPECT_THAT(routeInWorld(world, 3, "closet").route.nodes, ElementsAre(3, 2, 0));
}

TEST(RouteInWorld, GoesAroundAreasButIsNeverStopped) {
  const WorldMap world = sampleRoundTrip();
  EXPECT_THAT(routeInWorld(world, 0, 3).route.nodes, ElementsAre(0, 1, 3));
  for (const char* bathroom : {"1", "bathtub"}) {
    const WorldRoute around = routeInWorld(world, 0, 3, {.avoid = {bathroom}});
    EXPECT_THAT(around.route.nodes, ElementsAre(0, 2, 3)) << bathroom;
    EXPECT_DOUBLE_EQ(around.route.cost, around.driven->length);
    EXPECT_THAT(around.crossed, testing::IsEmpty());
  }
  RouteOptions fond;
  fond.preferFactor = 0.1;
  EXPECT_THAT(routeInWorld(world, 0, 3, {.prefer = {"corridor", "kitchen"}}, fond).route.nodes,
              ElementsAre(0, 2, 3));
  EXPECT_THAT(routeInWorld(world, 0, 1, {.avoid = {"1"}}).route.nodes, ElementsAre(0, 1));
  RouteOptions mild;
  mild.avoidFactor = 1.2;
  EXPECT_THAT(routeInWorld(world, 0, 3, {.avoid = {"1"}}, mild).route.nodes, ElementsAre(0, 1, 3));
}

/// What a meter costs in the middle of each of the four places.
std::vector<double> costsOf(const WorldMap& world, const RegionPreferences& preferences) {
  const RegionCosts costs = regionCosts(world, preferences, {});
  std::vector<double> result;
  for (std::size_t place = 0; place < 4; ++place)
    result.push_back(costs.at(place, world.areas.empty() ? -1 : static_cast<int>(place)));
  return result;
}

TEST(RegionCosts, WeighAreasRoomsAndWords) {
  WorldMap world = sampleWorld();
  EXPECT_THAT(costsOf(world, {.avoid = {"1", "bathtub"}}), ElementsAre(1, 5, 1, 1)) << "once";
  EXPECT_THAT(costsOf(world, {.avoid = {"0"}, .prefer = {"kitchen"}}), ElementsAre(2.5, 1, 1, 1));
  world.places.frames[7].room = "store";
  EXPECT_THAT(costsOf(world, {.prefer = {"Store"}}), ElementsAre(1, 1, 0.5, 1));
  EXPECT_THAT(costsOf(world, {.avoid = {"01"}}), costsOf(world, {.avoid = {"1"}}));
  for (const char* unknown : {"4", "-1", "99999999999999999999", "cellar", ""})
    EXPECT_THAT([&] { costsOf(world, {.avoid = {unknown}}); }, FailsWith(ErrorCode::unknownName)) << unknown;
  world.areas.clear();
  EXPECT_THAT(costsOf(world, {.avoid = {"bathtub"}}), ElementsAre(1, 5, 1, 1)) << "by words";
  EXPECT_THAT([&] { costsOf(world, {.avoid = {"cellar"}}); }, FailsWith(ErrorCode::unknownName));
  EXPECT_THAT([&] { costsOf(world, {.avoid = {"77"}}); }, FailsWith(ErrorCode::insufficientData));
}

TEST(RouteInWorld, RefusesNonsense) {
  const WorldMap world = sampleWorld();
  EXPECT_THAT([&] { routeInWorld(world, 9, "coffee mug"); }, FailsWith(ErrorCode::unknownName));
  EXPECT_THAT([&] { routeInWorld(world, 0, 9); }, FailsWith(ErrorCode::unknownName));
  EXPECT_THAT([&] { routeInWorld(world, 0, "xylophone"); }, FailsWith(ErrorCode::noAnswer));
  RouteOptions odd;
  odd.avoidFactor = 0.5;
  EXPECT_THAT([&] { routeInWorld(world, 0, 3, {}, odd); }, FailsWith(ErrorCode::invalidOption));
}

TEST(RouteInWorld, HasNoAnswerWhereNothingThatIsMeantIsReached) {
  WorldMap world = sampleWorld();
  world.places.transitions.clear();
  world.objects[3].givenName = "Rex";
  for (const bool posed : {true, false}) {
    if (!posed)
      for (MappedFrame& frame : world.places.frames) frame.pose.reset();
    for (const char* to : {"corridor", "dining table", "Rex"})
      EXPECT_THAT([&] { routeInWorld(world, 1, to); }, FailsWith(ErrorCode::noAnswer)) << to;
    EXPECT_THAT([&] { routeInWorld(world, 1, 2); }, FailsWith(ErrorCode::noAnswer));
    const auto routes = routesToEachArea(world, 1);
    ASSERT_EQ(routes.size(), 4U);
    EXPECT_TRUE(routes[1]);
    EXPECT_FALSE(routes[2]);
  }
}

TEST(WorldJson, TellsRoutes) {
  const WorldMap world = sampleWorld();
  const Json json = toJson("coffee mug", routeInWorld(world, 3, "coffee mug"), world);
  EXPECT_EQ(json["goal"], "object");
  EXPECT_EQ(json["to"], 0);
  EXPECT_EQ(json["pose"]["frame"], "frame_1.png");
  EXPECT_NEAR(json["pose"]["yaw"].get<double>(), std::atan2(2.4, 0.2), 1e-3);
  EXPECT_EQ(json["object"]["id"], 1);
  EXPECT_EQ(json["areas"][0]["name"], "Ana's \"room\"");
  EXPECT_EQ(toJson("corridor", routeInWorld(world, 0, "corridor"), world)["area"]["id"], 2);
  EXPECT_FALSE(toJson("", routeInWorld(world, 0, 3), world).contains("goal"));
  const Json named = toJson("mug", routeInWorld(world, 3, "mug", {.avoid = {"1"}}), world);
  EXPECT_EQ(named["matches"].size(), named["labels"].size());
  EXPECT_EQ(named["regions"][0]["use"], "avoid");
  EXPECT_EQ(named["regions"][0]["areas"][0]["id"], 1);
}

TEST(DrivenWays, FollowTheFramesToThePose) {
  const WorldMap world = sampleWorld();
  const WorldRoute found = routeInWorld(world, 3, "coffee mug");
  ASSERT_TRUE(found.driven);
  // Frame 5 is the middle of place 3; then 4, 3, 2, and 1, which faces the mug.
  EXPECT_EQ(found.driven->points, (std::vector<cv::Point2d>{{7.5, 4}, {7, 2}, {5, 2}, {2, 2}, {2, 4}}));
  EXPECT_NEAR(found.driven->length, std::hypot(0.5, 2) + 2 + 3 + 2, 1e-9);
}

TEST(DrivenWays, CrossWhereTheRobotCameByAgainUnlessAWallIsBetween) {
  WorldMap world = sampleWorld();
  world.places.frames[7].pose = Pose::planar(4.2, 5, 0);  // 7 → 1 was not driven; they are near each other
  world.places.frames[1].pose = Pose::planar(3.9, 5, 0);
  EXPECT_GT(DrivenWays(world, 2, {}).wayTo(1)->length, 5) << "all the way back around the wall";
  world.plan->walls = 0;
  EXPECT_NEAR(DrivenWays(world, 2, {}).wayTo(1)->length, 0.3, 1e-9);
  RouteOptions oneWay;
  oneWay.bidirectional = false;
  EXPECT_GT(DrivenWays(world, 2, oneWay).wayTo(1)->length, 0.3) << "it looked along x, away from there";
  const auto plan = std::exchange(world.plan, std::nullopt);
  EXPECT_NEAR(DrivenWays(world, 2, {}).wayTo(1)->length, 0.3, 1e-9) << "no walls are known";
  world.plan = plan;
  world.places.frames[1].pose->z = 3;
  EXPECT_GT(DrivenWays(world, 2, {}).wayTo(1)->length, 5) << "a floor above";
}

TEST(DrivenWays, AreAbsentWithoutPosesAndWhereTheRobotWasCarried) {
  WorldMap world = sampleWorld();
  RouteOptions oneWay;
  oneWay.bidirectional = false;
  EXPECT_FALSE(DrivenWays(world, 3, oneWay).wayTo(1)) << "it was driven the other way";
  EXPECT_TRUE(DrivenWays(world, 0, oneWay).wayTo(4));
  world.places.transitions.clear();
  EXPECT_FALSE(DrivenWays(world, 0, {}).wayTo(4));
  for (MappedFrame& frame : world.places.frames) frame.pose.reset();
  EXPECT_FALSE(DrivenWays(world, 0, {}).wayTo(0));
}

/// Two laps of the home, the second one slanted and backwards; a new place every 1.4 m, whatever the area is.
WorldMap crossingDrive() {
  WorldMap world = sampleWorld();
  TopologicalMap& map = world.places;
  const std::vector<cv::Point2d> corners{{2, 2}, {8, 2}, {8, 6}, {2, 6}, {2, 2},
                                         {3, 6}, {9, 6}, {7, 2}, {1, 2}, {2.5, 4}};
  map.frames.clear();
  map.nodes.clear();
  map.transitions.clear();
  world.areaOfFrame.clear();
  world.objects.clear();
  const auto add = [&](const cv::Point2d& at) {
    const int node = static_cast<int>(map.frames.size() / 7);
    if (node == static_cast<int>(map.nodes.size())) {
      map.nodes.push_back({node, 0, std::vector<float>(6, 0.1F), std::vector<float>(6, 0.01F)});
      if (node > 0) map.transitions.push_back({node - 1, node, 1, map.frames.size()});
    }
    ++map.nodes.back().frames;
    map.frames.push_back(test::sampleFrame(map.frames.size(), node, at.x, at.y, 0));
    world.areaOfFrame.push_back(areaAt(*world.plan, at, 1));
  };
  for (std::size_t i = 1; i < corners.size(); ++i) {
    const double steps = std::ceil(cv::norm(corners[i] - corners[i - 1]) / 0.2);
    for (double step = 0; step < steps; ++step)
      add(corners[i - 1] + (corners[i] - corners[i - 1]) * (step / steps));
  }
  return world;
}

/// How far a way leads through each area of the plan, looked at every centimeter [m].
std::map<int, double> lengthsUnder(const WorldMap& world, const DrivenWay& way) {
  std::map<int, double> lengths{{areaAt(*world.plan, way.points.front(), 0), 0},
                                {areaAt(*world.plan, way.points.back(), 0), 0}};
  for (std::size_t i = 1; i < way.points.size(); ++i) {
    const cv::Point2d step = way.points[i] - way.points[i - 1];
    for (double part = 0; part < 1; part += 0.01 / cv::norm(step))
      lengths[areaAt(*world.plan, way.points[i - 1] + step * part, 0)] += 0.01;
  }
  return lengths;
}

TEST(RouteInWorld, AvoidsAreasOnThePathThatIsDriven) {
  const WorldMap world = crossingDrive();
  RouteOptions strict;
  strict.avoidFactor = 1000;
  const int places = static_cast<int>(world.places.nodes.size());
  int around = 0;
  for (int from = 0; from < places; from += 9)
    for (int to = 0; to < places; ++to)
      for (int area = 0; area < 4; ++area) {
        const WorldRoute found = routeInWorld(world, from, to, {.avoid = {std::to_string(area)}}, strict);
        ASSERT_TRUE(found.driven);
        EXPECT_DOUBLE_EQ(found.route.cost, found.driven->length);
        const std::string text = fmt::format("{} → {} without {}", from, to, area);
        const auto isEnd = [&](const cv::Point2d& at) { return areaAt(*world.plan, at, 0.1) == area; };
        std::map<int, double> under = lengthsUnder(world, *found.driven);
        if (found.crossed.empty()) {
          EXPECT_LT(under[area], 0.1) << text;
        } else {
          EXPECT_TRUE(isEnd(found.driven->points.front()) || isEnd(found.driven->points.back())) << text;
          EXPECT_NE(found.crossed[0].why, CrossedRegion::Why::detour) << text;
        }
        for (const int passed : found.areas) EXPECT_TRUE(under.contains(passed)) << text;
        around += found.crossed.empty() &&
                  routeInWorld(world, from, to).driven->length < found.driven->length - 0.5;
      }
  EXPECT_GT(around, 6);
}

TEST(RouteInWorld, TellsWhatItCouldNotAvoid) {
  const WorldMap world = sampleRoundTrip();
  const auto why = [&](int from, int to, const RouteOptions& options) {
    const WorldRoute found = routeInWorld(world, from, to, {.avoid = {"1"}}, options);
    EXPECT_EQ(found.crossed.size(), 1U);
    return found.crossed.at(0);
  };
  EXPECT_EQ(why(0, 1, {}).why, CrossedRegion::Why::goal);
  EXPECT_EQ(why(1, 0, {}).why, CrossedRegion::Why::start);
  RouteOptions mild;
  mild.avoidFactor = 1.2;
  const CrossedRegion crossed = why(0, 3, mild);
  EXPECT_EQ(crossed.why, CrossedRegion::Why::detour);
  EXPECT_NEAR(crossed.length, 2, 0.2) << "from wall to wall";
  EXPECT_EQ(crossedText(crossed, mild).find("2.0 m of the way are in \"1\": no way around"), 0U);
  EXPECT_NE(crossedText(crossed, mild).find("--avoid-factor 1.2"), std::string::npos);
  EXPECT_EQ(crossedText({"hall", 0, CrossedRegion::Why::goal}, {}),
            "The way is partly in \"hall\": the goal is there");
  EXPECT_EQ(crossedText({"hall", 0, CrossedRegion::Why::start}, {}),
            "The way is partly in \"hall\": it starts there");
  const Json json = toJson("", routeInWorld(world, 0, 3, {.avoid = {"1"}}, mild), world);
  EXPECT_EQ(json["crossed"][0]["region"], "1");
  EXPECT_EQ(json["crossed"][0]["why"], "detour");
  EXPECT_EQ(json["cost"], json["driven"]["length"]);
  WorldMap dark = sampleWorld();
  for (MappedFrame& frame : dark.places.frames) frame.pose.reset();
  dark.plan.reset();
  const WorldRoute overPlaces = routeInWorld(dark, 0, 1, {.avoid = {"1"}});
  EXPECT_EQ(overPlaces.crossed.at(0).length, 0);
  EXPECT_TRUE(toJson("", overPlaces, dark)["crossed"][0]["length"].is_null());
}

TEST(RoutesToObjects, AreThoseOfRouteToEachAlone) {
  const WorldMap world = sampleWorld();
  const auto routes = routesToObjects(world, 3);
  ASSERT_EQ(routes.size(), world.objects.size());
  const WorldRoute found = routeInWorld(world, 3, "coffee mug");
  ASSERT_TRUE(routes[1] && routes[1]->driven && found.driven);
  EXPECT_EQ(routes[1]->route.nodes, found.route.nodes);
  EXPECT_EQ(routes[1]->pose->frame, found.pose->frame);
  EXPECT_EQ(routes[1]->driven->points, found.driven->points);
  EXPECT_THAT([&] { routesToObjects(world, 99); }, FailsWith(ErrorCode::unknownName));
}

}  // namespace
}  // namespace estancia
