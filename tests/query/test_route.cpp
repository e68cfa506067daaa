// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

#include "estancia/map_file/places.hpp"
#include "estancia/query/route.hpp"
#include "map_file/sample_map.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using testing::ElementsAre;

TEST(Places, LieAtTheMeanOfTheirFramesInTheRoomOfMost) {
  TopologicalMap map = test::sampleMap();
  map.frames = {test::frameAt("a", 0, 0, 0, "hall"), test::frameAt("b", 0, 2, 4, "hall"),
                test::frameAt("c", 0, 4, 2, "office"), test::frameAt("d", 3, 9, 9, "")};
  const std::vector<Place> places = placesOf(map);
  ASSERT_EQ(places.size(), map.nodes.size());
  EXPECT_EQ(places[0].position, (Position{2, 2, 0}));
  EXPECT_EQ(places[0].room, "hall");
  EXPECT_EQ(places[1].position, std::nullopt);
  EXPECT_EQ(places[2].room, "");
}

TEST(Links, AreTransitionsInEitherDirectionOnce) {
  const TopologicalMap map = test::sampleMap();
  EXPECT_THAT(linksOf(map), ElementsAre(testing::Pair(0U, 1U), testing::Pair(1U, 2U)));
}

TEST(Route, IsMeasuredInMetersWhereAllNodesHaveAPositionElseInTransitions) {
  TopologicalMap map = test::sampleMap();
  Route route = getRoute(map, 0, 3);
  EXPECT_THAT(route.nodes, ElementsAre(0, 1, 3));
  EXPECT_TRUE(route.metric);
  EXPECT_NEAR(route.cost, 2 * std::hypot(4, 0.5), 1e-9);
  EXPECT_THAT(getRoute(map, 3, 3).nodes, ElementsAre(3));
  map.frames[0].pose.reset();
  map.frames[1].pose.reset();
  route = getRoute(map, 0, 3);
  EXPECT_THAT(route.nodes, ElementsAre(0, 1, 3));
  EXPECT_FALSE(route.metric);
  EXPECT_DOUBLE_EQ(route.cost, 2);
}

TEST(Route, DrivesBackwardsUnlessForbidden) {
  RouteOptions oneWay;
  oneWay.bidirectional = false;
  EXPECT_THAT(getRoute(test::sampleMap(), 3, 0).nodes, ElementsAre(3, 1, 0));
  EXPECT_FALSE(findRoute(test::sampleMap(), 3, 0, oneWay));
  EXPECT_THAT([&] { getRoute(test::sampleMap(), 3, 0, oneWay); }, FailsWith(ErrorCode::noAnswer));
}

TEST(Route, IsTheCheapestOnRandomMaps) {
  std::mt19937 random(11);
  for (int round = 0; round < 30; ++round) {
    TopologicalMap map{.vocabulary = Vocabulary({"a"})};
    constexpr std::size_t count = 12;
    for (std::size_t i = 0; i < count; ++i) {
      map.nodes.push_back(test::nodeWith(static_cast<int>(i) * 3, 1, {1}));
      map.frames.push_back(test::frameAt("f", static_cast<int>(i) * 3, static_cast<double>(random() % 100),
                                         static_cast<double>(random() % 100), ""));
    }
    for (int i = 0; i < 16; ++i)
      map.transitions.push_back(
          {static_cast<int>(random() % count) * 3, static_cast<int>(random() % count) * 3, 1, 0});
    // Floyd and Warshall's all-pairs costs as the plain reference.
    constexpr double never = std::numeric_limits<double>::infinity();
    std::vector<std::vector<double>> cost(count, std::vector<double>(count, never));
    const std::vector<Place> places = placesOf(map);
    for (std::size_t i = 0; i < count; ++i) cost[i][i] = 0;
    for (const auto& [a, b] : linksOf(map))
      cost[a][b] = cost[b][a] = distanceBetween(*places[a].position, *places[b].position);
    for (std::size_t k = 0; k < count; ++k)
      for (std::size_t i = 0; i < count; ++i)
        for (std::size_t j = 0; j < count; ++j) cost[i][j] = std::min(cost[i][j], cost[i][k] + cost[k][j]);
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t j = 0; j < count; ++j) {
        const auto route = findRoute(map, map.nodes[i].id, map.nodes[j].id);
        ASSERT_EQ(route.has_value(), cost[i][j] != never);
        if (!route) continue;
        EXPECT_NEAR(route->cost, cost[i][j], 1e-9);
        double driven = 0;
        for (std::size_t step = 1; step < route->nodes.size(); ++step)
          driven += distanceBetween(*places[indexOf(map, route->nodes[step - 1])].position,
                                    *places[indexOf(map, route->nodes[step])].position);
        EXPECT_NEAR(driven, route->cost, 1e-9);
      }
  }
}

TEST(RouteToWords, EndsWhereTheWordIsMostProbable) {
  const WordRoute found = routeToWords(test::sampleMap(), 0, "desk");
  EXPECT_EQ(found.goal.node, 3);
  EXPECT_THAT(found.route.nodes, ElementsAre(0, 1, 3));
  EXPECT_THAT(found.meaning.labels, ElementsAre(2U));
}

TEST(RouteToWords, TakesTheNearestOfPlacesThatAreEquallyGood) {
  TopologicalMap map = test::sampleMap();
  map.nodes[1].mean[2] = 0.70F;  // the hall's desk is nearly as probable as the office's 0.75, and nearer
  EXPECT_EQ(routeToWords(map, 0, "desk").goal.node, 1);
  RouteOptions strict;
  strict.tolerance = 0;
  EXPECT_EQ(routeToWords(map, 0, "desk", strict).goal.node, 3);
}

TEST(RouteToWords, SettlesForTheBestReachablePlace) {
  TopologicalMap map = test::sampleMap();
  map.transitions.resize(1);  // the office is cut off
  EXPECT_EQ(routeToWords(map, 0, "desk").goal.node, 1);
  map.nodes[1].mean[2] = 0;
  EXPECT_THAT([&] { routeToWords(map, 0, "desk"); }, FailsWith(ErrorCode::noAnswer));
}

TEST(Route, RefusesNonsense) {
  TopologicalMap map = test::sampleMap();
  EXPECT_THAT([&] { getRoute(map, 0, 2); }, FailsWith(ErrorCode::unknownName));
  EXPECT_THAT([&] { getRoute(map, 7, 0); }, FailsWith(ErrorCode::unknownName));
  EXPECT_THAT([&] { routeToWords(map, 0, "desc"); }, FailsWith(ErrorCode::noAnswer));
  EXPECT_THAT([&] { routeToWords(map, 9, "desk"); }, FailsWith(ErrorCode::unknownName));
  RouteOptions odd;
  odd.tolerance = 2;
  EXPECT_THAT([&] { routeToWords(map, 0, "desk", odd); }, FailsWith(ErrorCode::invalidOption));
  map.transitions.resize(1);
  EXPECT_THAT([&] { getRoute(map, 0, 3); }, FailsWith(ErrorCode::noAnswer));
}

}  // namespace
}  // namespace estancia
