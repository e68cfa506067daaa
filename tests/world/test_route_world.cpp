// Ways to areas and objects, around what is to be avoided.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/world/route_world.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "estancia/world/world_json.hpp"
#include "support/errors.hpp"
#include "support/sample_world.hpp"

namespace estancia {
namespace {

using Json = nlohmann::ordered_json;
using test::FailsWith;
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
}

TEST(ViewPoses, DoNotLookFromBehindTheWallThatAThingStandsAt) {
  WorldMap world = sampleWorld();
  world.objects[1].center = {3.6, 6, 0.4};
  world.objects[1].size = {0.7, 1.6, 0.8};
  const auto fromTheCorridor = [](std::size_t frame) { return frame == 7; };
  EXPECT_TRUE(ViewPoses(world, 20).find(world.objects[1], fromTheCorridor));
  closeDoors(world);
  EXPECT_FALSE(ViewPoses(world, 20).find(world.objects[1], fromTheCorridor));
}

TEST(ViewPoses, SeeWhatHangsOnAWall) {
  WorldMap world = sampleWorld();
  closeDoors(world);
  world.objects[1].center = {4.05, 2, 0.3};
  const auto pose = ViewPoses(world, 20).find(world.objects[1], always);
  ASSERT_TRUE(pose);
  EXPECT_EQ(pose->frame, 2U);
}

TEST(ViewPoses, TurnToWhatOnlyTheBestFrameShows) {
  WorldMap world = sampleWorld();
  world.objects[1].center = {2, 0.2, 0.5};  // behind all frames
  const auto pose = ViewPoses(world, 20).find(world.objects[1], always);
  ASSERT_TRUE(pose);
  EXPECT_EQ(pose->frame, 1U);
  EXPECT_NEAR(pose->yaw, -std::numbers::pi / 2, 1e-9);
  EXPECT_FALSE(ViewPoses(world, 20).find(world.objects[1], [](std::size_t) { return false; }));
  world.places.frames[1].pose.reset();
  EXPECT_FALSE(ViewPoses(world, 20).find(world.objects[1], always));
  for (MappedFrame& frame : world.places.frames) frame.pose.reset();
  world.plan.reset();
  EXPECT_FALSE(ViewPoses(world, 20).find(world.objects[1], always));
}

TEST(RouteInWorld, EndsInThePlaceOfTheFrameThatFacesTheObject) {
  const WorldMap world = sampleWorld();
  const WorldRoute found = routeInWorld(world, 3, "coffee mug");
  ASSERT_TRUE(found.object && found.pose);
  EXPECT_EQ(found.object->object, 1);
  EXPECT_THAT(found.route.nodes, ElementsAre(3, 1, 0));
  EXPECT_EQ(world.places.frames[found.pose->frame].node, 0);
  EXPECT_THAT(areasAlong(world, found.route), ElementsAre(3, 1, 0));
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
  WorldMap world = sampleWorld();
  const WorldRoute found = routeInWorld(world, 0, "corridor");
  EXPECT_EQ(found.area, 2);
  EXPECT_THAT(found.route.nodes, ElementsAre(0, 2));
  world.areas.push_back({{.id = 4, .name = "mop"}, "closet"});
  EXPECT_THAT([&] { routeInWorld(world, 0, "closet"); }, FailsWith(ErrorCode::noAnswer, "closet"));
  world.areaOfFrame[7] = 4;
  EXPECT_THAT(routeInWorld(world, 0, "closet").route.nodes, ElementsAre(0, 2));
  world.areaOfFrame[0] = 4;  // one of three frames of place 0
  world.areaOfFrame[7] = 2;
  EXPECT_THAT(routeInWorld(world, 3, "closet").route.nodes, ElementsAre(3, 1, 0));
}

TEST(RouteInWorld, GoesAroundAreasButIsNeverStopped) {
  const WorldMap world = sampleWorld();
  EXPECT_THAT(routeInWorld(world, 0, 3).route.nodes, ElementsAre(0, 1, 3));
  for (const char* bathroom : {"1", "bathtub"}) {
    const WorldRoute around = routeInWorld(world, 0, 3, {.avoid = {bathroom}});
    EXPECT_THAT(around.route.nodes, ElementsAre(0, 2, 3)) << bathroom;
    EXPECT_NEAR(around.route.cost, getRoute(world.places, 0, 2).cost + getRoute(world.places, 2, 3).cost,
                1e-9);
  }
  EXPECT_THAT(routeInWorld(world, 0, 3, {.prefer = {"corridor"}}).route.nodes, ElementsAre(0, 2, 3));
  EXPECT_THAT(routeInWorld(world, 0, 1, {.avoid = {"1"}}).route.nodes, ElementsAre(0, 1));
  RouteOptions mild;
  mild.avoidFactor = 1.2;
  EXPECT_THAT(routeInWorld(world, 0, 3, {.avoid = {"1"}}, mild).route.nodes, ElementsAre(0, 1, 3));
}

TEST(CostFactors, WeighAreasRoomsAndWords) {
  WorldMap world = sampleWorld();
  const RouteOptions options;
  EXPECT_THAT(costFactors(world, {.avoid = {"1", "bathtub"}}, options), ElementsAre(1, 5, 1, 1)) << "once";
  EXPECT_THAT(costFactors(world, {.avoid = {"0"}, .prefer = {"kitchen"}}, options),
              ElementsAre(2.5, 1, 1, 1));
  world.places.frames[7].room = "store";
  EXPECT_THAT(costFactors(world, {.prefer = {"Store"}}, options), ElementsAre(1, 1, 0.5, 1));
  world.areas.clear();
  EXPECT_THAT(costFactors(world, {.avoid = {"bathtub"}}, options), ElementsAre(1, 5, 1, 1)) << "by words";
  for (const char* unknown : {"77", "cellar", ""})
    EXPECT_THAT([&] { costFactors(world, {.avoid = {unknown}}, options); },
                FailsWith(ErrorCode::unknownName, unknown));
}

TEST(RouteInWorld, RefusesNonsense) {
  const WorldMap world = sampleWorld();
  EXPECT_THAT([&] { routeInWorld(world, 9, "coffee mug"); }, FailsWith(ErrorCode::unknownName, "9"));
  EXPECT_THAT([&] { routeInWorld(world, 0, 9); }, FailsWith(ErrorCode::unknownName, "9"));
  EXPECT_THAT([&] { routeInWorld(world, 0, "xylophone"); }, FailsWith(ErrorCode::noAnswer, "xylophone"));
  RouteOptions odd;
  odd.avoidFactor = 0.5;
  EXPECT_THAT([&] { routeInWorld(world, 0, 3, {}, odd); },
              FailsWith(ErrorCode::invalidOption, "avoid-factor"));
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
  const Route route{{2, 0}, 0, true};
  EXPECT_GT(DrivenWays(world, {}).along(route, 1)->length, 5) << "all the way back around the wall";
  world.plan->walls = 0;
  EXPECT_NEAR(DrivenWays(world, {}).along(route, 1)->length, 0.3, 1e-9);
}

TEST(DrivenWays, AreAbsentWithoutPosesAndWhereTheRobotWasCarried) {
  WorldMap world = sampleWorld();
  RouteOptions oneWay;
  oneWay.bidirectional = false;
  EXPECT_FALSE(DrivenWays(world, oneWay).along({{3, 1, 0}, 0, true}, 1)) << "it was driven the other way";
  EXPECT_TRUE(DrivenWays(world, oneWay).along({{0, 1, 3}, 0, true}, 4));
  world.places.transitions.clear();
  EXPECT_FALSE(DrivenWays(world, {}).along({{0, 1, 3}, 0, true}, 4));
  for (MappedFrame& frame : world.places.frames) frame.pose.reset();
  EXPECT_FALSE(DrivenWays(world, {}).along({{0}, 0, true}));
}

TEST(DrivenWays, StayInTheRoutesPlacesWhereThatIsNotTooFar) {
  WorldMap world = sampleWorld();
  world.places.frames.push_back(test::sampleFrame(8, 0, 2, 4, 0));  // back from the corridor
  const DrivenWays ways(world, {});
  const double there = 3 + 2 + 2 * std::hypot(0.5, 2), back = 2 + std::hypot(3, 2) + 2;
  EXPECT_NEAR(ways.along({{0, 1, 3}, 0, true}, 6)->length, there, 1e-9);
  EXPECT_NEAR(ways.along({{0, 2, 3}, 0, true}, 6)->length, back, 1e-9);
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
  EXPECT_THAT([&] { routesToObjects(world, 99); }, FailsWith(ErrorCode::unknownName, "99"));
}

}  // namespace
}  // namespace estancia
