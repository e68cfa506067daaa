// SPDX-License-Identifier: Apache-2.0
#include "estancia/world/route_world.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "estancia/core/fail.hpp"
#include "estancia/core/label_words.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/topology/places.hpp"
#include "estancia/topology/ways.hpp"
#include "estancia/world/area_names.hpp"
#include "estancia/world/edit_areas.hpp"

namespace estancia {
namespace {

/// The areas that a text means, also by their number.
std::vector<int> regionAreas(const WorldMap& world, const std::string& text) {
  std::vector<int> called = areasCalled(world, text);
  if (!called.empty() || world.areas.empty()) return called;
  try {
    return {getArea(world, text).id};
  } catch (const Error&) {
    return {};
  }
}

[[noreturn]] void failUnknownRegion(const WorldMap& world, const std::string& text) {
  std::vector<std::string> known;
  for (const WorldArea& area : world.areas)
    known.push_back(fmt::format("{} ({})", area.id, area.displayName()));
  fail(ErrorCode::unknownName, "the map has no area, room or label \"{}\"{}", printable(text),
       known.empty() ? "" : fmt::format("; its areas are {}", fmt::join(known, ", ")));
}

/// Whether each node is in the region.
std::vector<bool> nodesIn(const WorldMap& world, const std::vector<int>& areas, const std::string& text) {
  const TopologicalMap& map = world.places;
  std::vector<bool> inside(map.nodes.size());
  if (const std::vector<int> region = regionAreas(world, text); !region.empty()) {
    for (std::size_t i = 0; i < inside.size(); ++i)
      inside[i] = std::ranges::find(region, areas[i]) != region.end();
    return inside;
  }
  const std::vector<Place> places = placesOf(map);
  for (std::size_t i = 0; i < inside.size(); ++i) inside[i] = sameWords(places[i].displayRoom(), text);
  if (std::ranges::find(inside, true) != inside.end()) return inside;
  if (findMeaning(map, text).empty()) failUnknownRegion(world, text);
  for (const PlaceAnswer& answer : ask(map, text, map.nodes.size()).places)
    inside[indexOf(map, answer.node)] = answer.isLikely() && answer.lift > 1;
  return inside;
}

/// Nodes of these areas; of those without one, nodes of which a frame is in them.
std::vector<int> nodesOfAreas(const WorldMap& world, const std::vector<int>& areas) {
  const auto isGoal = [&areas](int area) { return std::ranges::find(areas, area) != areas.end(); };
  const std::vector<int> areaOf = areasOfNodes(world);
  std::vector<int> nodes;
  for (std::size_t i = 0; i < areaOf.size(); ++i)
    if (isGoal(areaOf[i])) nodes.push_back(world.places.nodes[i].id);
  if (!nodes.empty()) return nodes;
  for (std::size_t i = 0; i < world.areaOfFrame.size(); ++i)
    if (isGoal(world.areaOfFrame[i])) nodes.push_back(world.places.frames[i].node);
  return nodes;
}

WorldRoute routeToAreas(const WorldMap& world, int from, const std::vector<int>& areas, const Ways& ways,
                        const RouteOptions& options) {
  const std::vector<int> nodes = nodesOfAreas(world, areas);
  const std::string& name = world.findArea(areas.front())->displayName();
  if (nodes.empty())
    throw NoAnswerError(fmt::format("the robot was never in \"{}\", only looked into it", name));
  const int goal = *std::ranges::min_element(nodes, {}, [&ways](int node) { return ways.costTo(node); });
  if (!ways.reaches(goal))
    throw NoAnswerError(
        fmt::format("there is no way from node {} to \"{}\"{}", from, name, whyNoWay(options)));
  const int area = areas.size() == 1 ? areas.front() : world.areaOfNode(goal);
  return {.route = ways.routeTo(goal), .area = area};
}

struct FacedObject {
  ObjectAnswer answer;
  double probability = 0;
  std::optional<ViewPose> pose = {};
};

/// A pose that faces the object, in a place that can be reached.
std::optional<ViewPose> findPose(const WorldMap& world, const ViewPoses& poses, const WorldObject& object,
                                 const Ways& ways) {
  return poses.find(object, [&](std::size_t frame) { return ways.reaches(world.places.frames[frame].node); });
}

std::optional<WorldRoute> routeToObject(const WorldMap& world, const std::vector<ObjectAnswer>& answers,
                                        const Ways& ways, const RouteOptions& options) {
  const ViewPoses poses(world, options.viewAngle);
  const auto nodeOf = [&world](std::size_t frame) { return world.places.frames[frame].node; };
  std::vector<FacedObject> goals;
  goals.reserve(answers.size());
  for (const ObjectAnswer& answer : answers)
    goals.push_back(
        {answer, answer.probability, findPose(world, poses, *world.findObject(answer.object), ways)});
  std::erase_if(goals, [](const FacedObject& goal) { return !goal.pose; });
  const FacedObject* goal = chooseGoal(goals, options.tolerance, [&](const FacedObject& candidate) {
    return ways.costTo(nodeOf(candidate.pose->frame));
  });
  if (goal == nullptr) return std::nullopt;
  return WorldRoute{
      .route = ways.routeTo(nodeOf(goal->pose->frame)), .object = goal->answer, .pose = goal->pose};
}

WorldRoute routeToMeaning(const WorldMap& world, int from, const std::string& to, const Ways& ways,
                          const RouteOptions& options) {
  const WorldAnswers answers = askWorld(world, to, world.places.nodes.size(), world.objects.size());
  if (!answers.areas.empty()) return routeToAreas(world, from, answers.areas, ways, options);
  std::vector<ObjectAnswer> objects = answers.objects;
  if (std::ranges::any_of(objects, &ObjectAnswer::isLikely))
    std::erase_if(objects, [](const ObjectAnswer& answer) { return !answer.isLikely(); });
  else if (!objects.empty() && !answers.places.empty() &&
           objects.front().probability < answers.places.front().probability)
    objects.clear();
  if (auto route = routeToObject(world, objects, ways, options)) return *route;
  const PlaceAnswer* goal = chooseGoal(answers.places, options.tolerance, [&ways](const PlaceAnswer& answer) {
    return ways.costTo(answer.node);
  });
  if (goal == nullptr)
    throw NoAnswerError(fmt::format("no {} with \"{}\" can be reached from node {}{}",
                                    answers.places.empty() ? "object" : "place", printable(to), from,
                                    whyNoWay(options)));
  return {.route = ways.routeTo(goal->node), .place = *goal, .meaning = {answers.labels, answers.rooms}};
}

}  // namespace

std::vector<double> costFactors(const WorldMap& world, const RegionPreferences& preferences,
                                const RouteOptions& options) {
  std::vector<double> factors(world.places.nodes.size(), 1);
  const std::vector<int> areas = areasOfNodes(world);
  const auto weigh = [&](const std::vector<std::string>& regions, double factor) {
    std::vector<bool> inside(factors.size());
    for (const std::string& region : regions) {
      const std::vector<bool> nodes = nodesIn(world, areas, region);
      for (std::size_t i = 0; i < inside.size(); ++i) inside[i] = inside[i] || nodes[i];
    }
    for (std::size_t i = 0; i < inside.size(); ++i)
      if (inside[i]) factors[i] *= factor;
  };
  weigh(preferences.avoid, options.avoidFactor);
  weigh(preferences.prefer, options.preferFactor);
  return factors;
}

WorldRoute routeInWorld(const WorldMap& world, int from, int to, const RegionPreferences& preferences,
                        const RouteOptions& options) {
  validate(options);
  world.places.getNode(to);
  const std::vector<double> factors = costFactors(world, preferences, options);
  const Ways ways(world.places, from, options, factors);
  if (!ways.reaches(to))
    throw NoAnswerError(
        fmt::format("there is no way from node {} to node {}{}", from, to, whyNoWay(options)));
  WorldRoute found{.route = ways.routeTo(to)};
  found.driven = DrivenWays(world, options, factors).along(found.route);
  return found;
}

WorldRoute routeInWorld(const WorldMap& world, int from, const std::string& to,
                        const RegionPreferences& preferences, const RouteOptions& options) {
  validate(options);
  const std::vector<double> factors = costFactors(world, preferences, options);
  WorldRoute found = routeToMeaning(world, from, to, Ways(world.places, from, options, factors), options);
  const DrivenWays driven(world, options, factors);
  found.driven = found.pose ? driven.along(found.route, found.pose->frame) : driven.along(found.route);
  return found;
}

std::vector<std::optional<WorldRoute>> routesToObjects(const WorldMap& world, int from,
                                                       const RouteOptions& options) {
  validate(options);
  const Ways ways(world.places, from, options);
  const ViewPoses poses(world, options.viewAngle);
  const DrivenWays driven(world, options);
  std::vector<std::optional<WorldRoute>> routes;
  for (const WorldObject& object : world.objects) {
    routes.emplace_back();
    const std::optional<ViewPose> pose = findPose(world, poses, object, ways);
    if (!pose) continue;
    WorldRoute found{.route = ways.routeTo(world.places.frames[pose->frame].node), .pose = pose};
    found.driven = driven.along(found.route, pose->frame);
    routes.back() = std::move(found);
  }
  return routes;
}

std::vector<int> areasAlong(const WorldMap& world, const Route& route) {
  std::vector<int> along;
  const std::vector<int> areas = areasOfNodes(world);
  for (const int node : route.nodes)
    if (const int area = areas[indexOf(world.places, node)];
        area >= 0 && (along.empty() || along.back() != area))
      along.push_back(area);
  return along;
}

}  // namespace estancia
