// SPDX-License-Identifier: Apache-2.0
#include "estancia/world_query/route_world.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>

#include "estancia/core/error.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/map_file/places.hpp"
#include "estancia/query/ways.hpp"
#include "estancia/world_query/driven_way.hpp"

namespace estancia {
namespace {

/// The cheapest ways to places and frames: as driven, or, where the robot was carried and without poses, over
/// the transitions between places.
class WorldWays {
 public:
  WorldWays(const WorldMap& world, int from, const RegionCosts& costs, const RouteOptions& options)
      : world_(world),
        costs_(costs),
        driven_(world, from, options, costs),
        places_(world.places, from, options, placeFactors(world, costs)) {}

  double costTo(std::size_t frame) const {
    const double cost = driven_.costTo(frame);
    return isReached(cost) ? cost : places_.costTo(world_.places.frames[frame].node);
  }

  bool reaches(std::size_t frame) const { return isReached(costTo(frame)); }
  double costToNode(int node) const {
    const auto middle = driven_.middleOf(node);
    return middle ? costTo(*middle) : places_.costTo(node);
  }

  bool reachesNode(int node) const { return isReached(costToNode(node)); }

  WorldRoute routeTo(std::size_t frame) const {
    if (auto way = driven_.wayTo(frame)) return driven(std::move(*way));
    return overPlaces(world_.places.frames[frame].node);
  }

  WorldRoute routeToNode(int node) const {
    const auto middle = driven_.middleOf(node);
    return middle ? routeTo(*middle) : overPlaces(node);
  }

  const DrivenWays& driven() const { return driven_; }
  const RegionCosts& costs() const { return costs_; }

 private:
  static bool isReached(double cost) { return cost < std::numeric_limits<double>::infinity(); }
  static std::vector<double> placeFactors(const WorldMap& world, const RegionCosts& costs) {
    std::vector<double> factors;
    for (const int area : areasOfNodes(world)) factors.push_back(costs.at(factors.size(), area));
    return factors;
  }

  WorldRoute driven(DrivenWay way) const {
    WorldRoute found{.route = {{}, way.length, true}};
    for (const WayPiece& piece : way.pieces) {
      const int node = world_.places.nodes[piece.place].id;
      if (found.route.nodes.empty() || found.route.nodes.back() != node) found.route.nodes.push_back(node);
      if (piece.area >= 0 && (found.areas.empty() || found.areas.back() != piece.area))
        found.areas.push_back(piece.area);
    }
    tellCrossed(found, way.pieces);
    found.driven = std::move(way);
    return found;
  }

  WorldRoute overPlaces(int node) const {
    WorldRoute found{.route = places_.routeTo(node)};
    const std::vector<int> areas = areasOfNodes(world_);
    std::vector<WayPiece> pieces;
    for (const int id : found.route.nodes) {
      const std::size_t place = indexOf(world_.places, id);
      pieces.push_back({place, areas[place]});
      if (areas[place] >= 0 && (found.areas.empty() || found.areas.back() != areas[place]))
        found.areas.push_back(areas[place]);
    }
    tellCrossed(found, pieces);
    return found;
  }

  void tellCrossed(WorldRoute& found, const std::vector<WayPiece>& pieces) const {
    for (const MapRegion& region : costs_.avoid) {
      const auto isInside = [&region](const WayPiece& piece) {
        return region.holds(piece.place, piece.area);
      };
      if (std::ranges::none_of(pieces, isInside)) continue;
      CrossedRegion crossed{region.name};
      for (const WayPiece& piece : pieces) crossed.length += isInside(piece) ? piece.length : 0;
      crossed.why = isInside(pieces.back())    ? CrossedRegion::Why::goal
                    : isInside(pieces.front()) ? CrossedRegion::Why::start
                                               : CrossedRegion::Why::detour;
      found.crossed.push_back(std::move(crossed));
    }
  }

  const WorldMap& world_;
  RegionCosts costs_;
  DrivenWays driven_;
  Ways places_;
};

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

WorldRoute routeToAreas(const WorldMap& world, int from, const std::vector<int>& areas, const WorldWays& ways,
                        const RouteOptions& options) {
  const std::vector<int> nodes = nodesOfAreas(world, areas);
  const std::string& name = world.findArea(areas.front())->displayName();
  if (nodes.empty())
    throw NoAnswerError(fmt::format("the robot was never in \"{}\", only looked into it", name));
  // The middle of a place may lie in another area than most of it.
  const auto frameOf = [&](int node) { return ways.driven().middleOf(node, areas); };
  const int goal = *std::ranges::min_element(nodes, {}, [&](int node) {
    const auto frame = frameOf(node);
    return frame ? ways.costTo(*frame) : ways.costToNode(node);
  });
  const auto frame = frameOf(goal);
  if (!(frame ? ways.reaches(*frame) : ways.reachesNode(goal)))
    throw NoAnswerError(
        fmt::format("there is no way from node {} to \"{}\"{}", from, name, whyNoWay(options)));
  WorldRoute found = frame ? ways.routeTo(*frame) : ways.routeToNode(goal);
  found.area = areas.size() == 1 ? areas.front() : frame ? world.areaOfFrame[*frame] : world.areaOfNode(goal);
  return found;
}

struct FacedObject {
  ObjectAnswer answer;
  double probability = 0;
  ViewPose pose;
};

std::optional<WorldRoute> routeToObject(const WorldMap& world, const std::vector<ObjectAnswer>& answers,
                                        const WorldWays& ways, const RouteOptions& options) {
  const ViewPoses poses(world, options.viewAngle);
  const auto mayUse = [&ways](std::size_t frame) { return ways.reaches(frame); };
  std::vector<FacedObject> goals;
  for (const ObjectAnswer& answer : answers)
    if (const auto pose = poses.find(*world.findObject(answer.object), mayUse))
      goals.push_back({answer, answer.probability, *pose});
  const FacedObject* goal = chooseGoal(goals, options.tolerance, [&](const FacedObject& candidate) {
    return ways.costTo(candidate.pose.frame);
  });
  if (goal == nullptr) return std::nullopt;
  WorldRoute found = ways.routeTo(goal->pose.frame);
  found.object = goal->answer;
  found.pose = goal->pose;
  return found;
}

WorldRoute routeToAnswer(const WorldMap& world, int from, const std::string& to, const WorldAnswers& answers,
                         const WorldWays& ways, const RouteOptions& options) {
  const bool areOnlyAreas = answers.objects.empty() && answers.places.empty();
  if (!answers.areas.empty() && (answers.isWholeName || areOnlyAreas))
    return routeToAreas(world, from, answers.areas, ways, options);
  std::vector<ObjectAnswer> objects = answers.objects;
  if (std::ranges::any_of(objects, &ObjectAnswer::isLikely))
    std::erase_if(objects, [](const ObjectAnswer& answer) { return !answer.isLikely(); });
  else if (!objects.empty() && !answers.places.empty() &&
           objects.front().probability < answers.places.front().probability)
    objects.clear();
  if (auto route = routeToObject(world, objects, ways, options)) return *route;
  const PlaceAnswer* goal = chooseGoal(answers.places, options.tolerance, [&ways](const PlaceAnswer& answer) {
    return ways.costToNode(answer.node);
  });
  if (goal == nullptr)
    throw NoAnswerError(fmt::format("no {} with \"{}\" can be reached from node {}{}",
                                    answers.places.empty() ? "object" : "place", printable(to), from,
                                    whyNoWay(options)));
  WorldRoute found = ways.routeToNode(goal->node);
  found.place = *goal;
  return found;
}

}  // namespace

WorldRoute routeInWorld(const WorldMap& world, int from, int to, const RegionPreferences& preferences,
                        const RouteOptions& options, WordGraphSource source) {
  validate(options);
  world.places.getNode(to);
  const WorldWays ways(world, from, regionCosts(world, preferences, options, source), options);
  if (!ways.reachesNode(to))
    throw NoAnswerError(
        fmt::format("there is no way from node {} to node {}{}", from, to, whyNoWay(options)));
  WorldRoute found = ways.routeToNode(to);
  found.regions = ways.costs();
  return found;
}

WorldRoute routeInWorld(const WorldMap& world, int from, const std::string& to,
                        const RegionPreferences& preferences, const RouteOptions& options,
                        WordGraphSource source) {
  validate(options);
  const WorldWays ways(world, from, regionCosts(world, preferences, options, source), options);
  const WorldAnswers answers = askWorld(world, to, world.places.nodes.size(), world.objects.size(), source);
  WorldRoute found = routeToAnswer(world, from, to, answers, ways, options);
  found.meaning = answers;
  found.regions = ways.costs();
  return found;
}

std::vector<std::optional<WorldRoute>> routesToObjects(const WorldMap& world, int from,
                                                       const RouteOptions& options) {
  validate(options);
  const WorldWays ways(world, from, {}, options);
  const ViewPoses poses(world, options.viewAngle);
  const auto mayUse = [&ways](std::size_t frame) { return ways.reaches(frame); };
  std::vector<std::optional<WorldRoute>> routes;
  for (const WorldObject& object : world.objects) {
    routes.emplace_back();
    if (const auto pose = poses.find(object, mayUse)) {
      routes.back() = ways.routeTo(pose->frame);
      routes.back()->pose = pose;
    }
  }
  return routes;
}

std::vector<std::optional<WorldRoute>> routesToEachArea(const WorldMap& world, int from,
                                                        const RouteOptions& options) {
  validate(options);
  const WorldWays ways(world, from, {}, options);
  std::vector<std::optional<WorldRoute>> routes;
  for (const WorldArea& area : world.areas) {
    routes.emplace_back();
    try {
      routes.back() = routeToAreas(world, from, {area.id}, ways, options);
    } catch (const NoAnswerError&) {  // no drive was there
    }
  }
  return routes;
}

std::string crossedText(const CrossedRegion& crossed, const RouteOptions& options) {
  const std::string where =
      crossed.length > 0 ? fmt::format("{:.1f} m of the way are", crossed.length) : "The way is partly";
  const std::string why =
      crossed.why == CrossedRegion::Why::goal ? "the goal is there"
      : crossed.why == CrossedRegion::Why::start
          ? "it starts there"
          : fmt::format("no way around it is known that costs less (--avoid-factor {})", options.avoidFactor);
  return fmt::format("{} in \"{}\": {}", where, printable(crossed.name), why);
}

}  // namespace estancia
