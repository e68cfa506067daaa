// What is asked of a map: words, decisions, ways, all of it as JSON.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>

#include "estancia/core/label_words.hpp"
#include "estancia/map_file/places.hpp"
#include "estancia/query/ask.hpp"
#include "estancia/query/explain.hpp"
#include "estancia/query/map_json.hpp"
#include "estancia/query/route.hpp"
#include "map_file/sample_map.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using Json = nlohmann::ordered_json;
using test::FailsWith;
using testing::ElementsAre;

TEST(Ask, RanksPlacesByProbability) {
  const Answers answers = ask(test::sampleMap(), "Umbrella");
  EXPECT_THAT(answers.labels, ElementsAre(3U));
  ASSERT_EQ(answers.places.size(), 3U);
  const PlaceAnswer& best = answers.places[0];
  EXPECT_EQ(best.node, 1);
  EXPECT_FLOAT_EQ(static_cast<float>(best.probability), 0.7F);
  EXPECT_EQ(best.rank, 1U);
  EXPECT_TRUE(best.inTop5);
  // mean over the 7 images: (2·0.1 + 3·0.7 + 2·0) / 7
  EXPECT_NEAR(best.lift, 0.7 / (2.3 / 7), 1e-6);
  EXPECT_EQ(answers.places[1].node, 0);
  EXPECT_EQ(answers.places[1].rank, 4U);
  EXPECT_EQ(answers.places[2].node, 3);
  EXPECT_EQ(answers.places[2].rank, 5U);
  EXPECT_EQ(ask(test::sampleMap(), "umbrella", 1).places.size(), 1U);

  TopologicalMap six{.vocabulary = Vocabulary({"a", "b", "c", "d", "e", "f"})};
  six.nodes = {test::nodeWith(0, 1, {0.1F, 0.2F, 0.2F, 0.2F, 0.2F, 0.2F})};
  EXPECT_EQ(ask(six, "a").places[0].rank, 6U);
  EXPECT_FALSE(ask(six, "a").places[0].inTop5);
  EXPECT_TRUE(ask(six, "f").places[0].inTop5);
}

TEST(Ask, AddsUpAllMatchingLabelsButNeverAboveOne) {
  TopologicalMap map{.vocabulary = Vocabulary({"wine bottle", "water bottle", "desk"})};
  map.nodes = {test::nodeWith(0, 1, {0.3F, 0.2F, 0.5F}), test::nodeWith(1, 1, {0.9F, 0.8F, 0.1F})};
  const Answers answers = ask(map, "bottles");
  EXPECT_THAT(answers.labels, ElementsAre(0U, 1U));
  EXPECT_EQ(answers.places[0].node, 1);
  EXPECT_DOUBLE_EQ(answers.places[0].probability, 1);
  EXPECT_NEAR(answers.places[1].probability, 0.5, 1e-6);
  EXPECT_EQ(answers.places[1].label, 0U);
  EXPECT_EQ(answers.places[1].rank, 2U);
}

TEST(Ask, SuggestsNearSpellingsAndRefusesAnEmptyMap) {
  TopologicalMap map = test::sampleMap();
  const test::Caught caught = test::caught([&] { ask(map, "umbrela"); });
  EXPECT_THAT(caught, FailsWith(ErrorCode::noAnswer));
  EXPECT_THAT(caught.message, testing::HasSubstr("\"umbrella\""));
  for (const char* unknown : {"xylophone", ""})
    EXPECT_THAT([&] { ask(map, unknown); }, FailsWith(ErrorCode::noAnswer)) << unknown;
  map.nodes.clear();
  EXPECT_THAT([&] { ask(map, "desk"); }, FailsWith(ErrorCode::insufficientData));
}

TEST(MapJson, ABeliefOutsideOfAllZonesIsNull) {
  Localization answer;
  for (const auto& [zone, told] : {std::pair<int, Json>{2, 2}, {-1, nullptr}}) {
    answer.beliefZone = zone;
    EXPECT_EQ(toJson("now.jpg", answer, test::sampleMap())["belief_zone"], told);
  }
}

TEST(Explain, EveryKindOfDecision) {
  const TopologicalMap map = test::sampleMap();
  EXPECT_THAT(explain(map, 0), ElementsAre("Frame 0 (a.jpg) made node 0.",
                                           "It was the first image: there was nothing to compare it with."));
  EXPECT_THAT(explain(map, 1),
              ElementsAre("Frame 1 (b.jpg) stayed in node 0.",
                          "Its distance to the current node 0, 0.1, is below tau_join 0.3: it stayed there, "
                          "and no other node was compared.",
                          "With a tau_join of 0.1 or less it would have left node 0."));
  EXPECT_THAT(
      explain(map, 6),
      ElementsAre("Frame 6 (g.jpg) returned to node 1.",
                  "Its distance to the current node 3, 0.65, is not below tau_join 0.3: it left that node.",
                  "The nearest other node, 1, is 0.1 away, below tau_revisit 0.25 and nearer than the "
                  "current one: it moved there.",
                  "With a tau_join above 0.65 it would have stayed in node 3; with a tau_revisit of 0.1 or "
                  "less it would have made a new node."));
  EXPECT_EQ(explain(map, 4)[2],
            "The nearest other node, 1, is 0.6 away, not below tau_revisit 0.25: it made a new node, 3.");
  EXPECT_EQ(explain(map, 2).size(), 5U) << "compared with no other node, and merged later";
  EXPECT_EQ(explain(map, 3).back(),
            "After frame 5 node 2 turned out to be the same place as node 1 (distance 0.12, below 0.2): the "
            "frame belongs to node 1 since.");
  EXPECT_EQ(explain(map, 6).size(), 4U) << "the merge was before that frame";
}

TEST(Explain, AnImageOfAnotherSideOfAPlace) {
  TopologicalMap map = test::sampleMap();
  map.decisions[6].toCurrent = 0.2;
  EXPECT_EQ(explain(map, 6).size(), 2U) << "no threshold would have changed it";
  Decision& stayed = map.decisions[1];
  stayed.toCurrent = 0.4;
  stayed.other = stayed.current;
  stayed.toOther = 0.1;
  stayed.tauRevisit = 0.25;
  EXPECT_EQ(
      explain(map, 1)[1],
      "Its distance to the current node 0, 0.4, is not below tau_join 0.3, but an earlier image of that "
      "node is 0.1 away, below 0.25: it stayed there.");
  Decision& made = map.decisions[4];
  made.toOther = made.toCurrent = 0.2;
  made.tauJoin = 0.1;
  EXPECT_EQ(explain(map, 4)[2],
            "The nearest other node, 1, is 0.2 away, below tau_revisit 0.25 but not nearer than the current "
            "one: it made a new node, 3.");
}

TEST(Explain, TheBeginOfALaterDriveAndAPlaceForWhichThereWasNoMemory) {
  TopologicalMap map = test::sampleMap();
  map.decisions[1] = {1, DecisionKind::localize, 0, -1, 0, 0, 0.1, 0.3, 0.25};
  map.decisions[2] = {2, DecisionKind::revisit, 1, -1, 0, 1, 0.1, 0.3, 0.25};
  map.decisions[3] = {3, DecisionKind::revisit, 1, 0, 0.2, 1, 0.1, 0.3, 0.25};
  map.decisions[4] = {4, DecisionKind::start, 3, -1, 0, 1, 0.6, 0.3, 0.25};
  map.merges = {{5, 1, 3, 0.5, std::numeric_limits<double>::infinity()}};
  EXPECT_EQ(explain(map, 1)[0], "Frame 1 (b.jpg) was localized in node 0.");
  map.decisions[1].current = 0;
  EXPECT_EQ(explain(map, 1)[0], "Frame 1 (b.jpg) stayed in node 0.");
  EXPECT_EQ(explain(map, 2)[1],
            "It was the first image of a drive. Node 1 is 0.1 away, below 0.25: it began there.");
  EXPECT_EQ(explain(map, 3)[1],
            "An earlier image of node 1 is 0.1 away, below 0.25: it moved there, though its distance to the "
            "current node 0, 0.2, is below tau_join 0.3.");
  EXPECT_EQ(explain(map, 4)[1],
            "It was the first image of a drive. The nearest node, 1, is 0.6 away, not below 0.25: the drive "
            "began in a new place.");
  EXPECT_EQ(
      explain(map, 4)[2],
      "After frame 5 node 3, which held few frames, became a part of its neighbor, node 1: there was no "
      "memory for another place (--memory).");
}

TEST(Explain, FindsFramesByNameThenByNumber) {
  TopologicalMap map = test::sampleMap();
  EXPECT_EQ(getFrame(map, "d.jpg"), 3U);
  EXPECT_EQ(getFrame(map, "3"), 3U);
  map.frames[6].name = "3";
  EXPECT_EQ(getFrame(map, "3"), 6U);
  map.frames[6].name = "7";
  EXPECT_THAT([&] { explain(map, 7); }, FailsWith(ErrorCode::unknownName)) << "a number, not a name";
}

TEST(Explain, AsksForANumberWhereDrivesNameTheirImagesAlike) {
  TopologicalMap map = test::sampleMap();
  map.drives = {{0, "monday"}, {4, "tuesday"}};
  for (std::size_t i = 0; i < map.frames.size(); ++i) map.frames[i].number = 10 * i;
  map.frames[5].name = map.frames[1].name;
  EXPECT_THAT([&] { getFrame(map, "b.jpg"); }, FailsWith(ErrorCode::unknownName));
  EXPECT_EQ(getFrame(map, "50"), 5U);
  EXPECT_THAT([&] { getFrame(map, "5"); }, FailsWith(ErrorCode::unknownName));
  map.drives[0].name.clear();
  EXPECT_THAT([&] { getFrame(map, "b.jpg"); }, FailsWith(ErrorCode::unknownName));
  map.drives.clear();
  for (MappedFrame& frame : map.frames) frame.name = "a.jpg";
  EXPECT_THAT([&] { getFrame(map, "a.jpg"); }, FailsWith(ErrorCode::unknownName));
}

TEST(Explain, SaysWhichFramesThereAre) {
  TopologicalMap map = test::sampleMap();
  for (const char* wrong : {"7", "x.jpg", "-1", "3x", "", "99999999999999999999999"})
    EXPECT_THAT([&] { getFrame(map, wrong); }, FailsWith(ErrorCode::unknownName)) << wrong;
  map.decisions.clear();
  EXPECT_THAT([&] { explain(map, 2); }, FailsWith(ErrorCode::insufficientData));
  map.frames.clear();
  EXPECT_THAT([&] { explain(map, 0); }, FailsWith(ErrorCode::insufficientData));
}

TEST(MapJson, TellsAnswers) {
  const TopologicalMap map = test::sampleMap();
  const Json json = toJson("desk", ask(map, "desk", 2), map, placesOf(map));
  EXPECT_EQ(json["words"], "desk");
  EXPECT_EQ(json["labels"], Json({"desk"}));
  EXPECT_EQ(json["rooms"], Json::array());
  ASSERT_EQ(json["places"].size(), 2U);
  EXPECT_EQ(json["places"][0]["node"], 3);
  EXPECT_EQ(json["places"][0]["label"], "desk");
  EXPECT_EQ(json["places"][0]["rank"], 1);
  EXPECT_EQ(json["places"][0]["among_best_5"], true);
  EXPECT_EQ(json["places"][0]["room"], "office");
  EXPECT_FALSE(json["places"][0].contains("predicted_room"));
}

TEST(MapJson, TellsPredictedRooms) {
  TopologicalMap map = test::sampleMap();
  map.predictions = RoomPredictions{"knn", {"bureau", "kitchen"}, DescriptorMatrix(2)};
  for (std::size_t i = 0; i < map.frames.size(); ++i)
    map.predictions->probabilities.append(i < 2 ? std::vector<float>{0.25F, 0.75F}
                                                : std::vector<float>{1, 0});
  const Json json = toJson("kitchen", ask(map, "kitchen"), map, placesOf(map));
  EXPECT_EQ(json["labels"], Json::array());
  EXPECT_EQ(json["rooms"], Json({"kitchen"}));
  EXPECT_EQ(json["places"][0]["node"], 0);
  EXPECT_EQ(json["places"][0]["label"], nullptr);
  EXPECT_EQ(json["places"][0]["predicted_room"], "kitchen");
  EXPECT_NEAR(json["places"][0]["room_probability"].get<double>(), 0.75, 1e-6);
}

TEST(MapJson, TellsWaysToLabelsAndToPredictedRooms) {
  TopologicalMap map = test::sampleMap();
  const Json json = toJson("desk", routeToWords(map, 0, "desk"), map);
  EXPECT_EQ(json["nodes"], Json({0, 1, 3}));
  EXPECT_EQ(json["unit"], "m");
  EXPECT_EQ(json["label"], "desk");
  EXPECT_NEAR(json["probability"].get<double>(), 0.75, 1e-6);
  map.predictions = RoomPredictions{"knn", {"bureau"}, DescriptorMatrix(1)};
  for (std::size_t i = 0; i < map.frames.size(); ++i)
    map.predictions->probabilities.append(std::vector<float>{1});
  EXPECT_EQ(toJson("bureau", routeToWords(map, 0, "bureau"), map)["room"], "bureau");
}

TEST(MapJson, TellsWhereAnImageWasTaken) {
  Localization answer;
  answer.node = 3;
  answer.nearestImage = 4;
  answer.beliefNode = 1;
  answer.beliefImage = 6;
  answer.unmapped = 0.25;
  answer.confidence = 0.5;
  EXPECT_EQ(toJson("now.jpg", answer, test::sampleMap()), (Json{{"image", "now.jpg"},
                                                                {"node", 3},
                                                                {"nearest_image", "e.jpg"},
                                                                {"nearest_frame", 4},
                                                                {"distance", 0.0},
                                                                {"belief_node", 1},
                                                                {"belief_image", "g.jpg"},
                                                                {"belief_frame", 6},
                                                                {"confidence", 0.5},
                                                                {"unmapped", 0.25},
                                                                {"unvisited", nullptr}}));
}

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
