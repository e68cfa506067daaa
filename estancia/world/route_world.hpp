// Route planning in a world: to a place, an area, an object, or to words; areas are avoided or preferred.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "estancia/topology/route.hpp"
#include "estancia/world/ask_world.hpp"
#include "estancia/world/driven_way.hpp"
#include "estancia/world/view_pose.hpp"
#include "estancia/world/world_map.hpp"

namespace estancia {

/// Regions that a robot behaves differently in (thesis 5.6): each is an area (its number or name, as
/// getArea()), else a room of places (true or predicted), else words: the places that are likely to hold them
/// (PlaceAnswer::isLikely()) and hold them more than the map's mean.
struct RegionPreferences {
  std::vector<std::string> avoid = {}, prefer = {};
};

/// What a meter costs in each place, in the order of map.nodes: RouteOptions::avoidFactor and preferFactor,
/// both where regions overlap. Throws Error (unknownName) where nothing has that name.
std::vector<double> costFactors(const WorldMap& world, const RegionPreferences& preferences,
                                const RouteOptions& options);

struct WorldRoute {
  /// Its cost is what is driven, whatever is avoided.
  Route route;
  /// The area that the goal names; -1 for none.
  int area = -1;
  /// The object at the goal, and where to stand and look: in the last place of the route.
  std::optional<ObjectAnswer> object = {};
  std::optional<ViewPose> pose = {};
  /// The place that holds the words, where no area or object was found, and what the words matched.
  std::optional<PlaceAnswer> place = {};
  Meaning meaning = {};
  /// The way on the floor, to the pose where there is one. Absent without poses, or where the frames between
  /// were not driven one after the other.
  std::optional<DrivenWay> driven = {};
};

/// The cheapest way to a node. Throws Error: unknownName when a node or a region does not exist; noAnswer
/// when there is no way.
WorldRoute routeInWorld(const WorldMap& world, int from, int to, const RegionPreferences& preferences = {},
                        const RouteOptions& options = {});

/// The way to an area of that given name; else to the object that the words mean, to a pose that faces it
/// (ViewPoses); else to the place that holds them (routeToWords()). An object that is hardly likely to be
/// meant (ObjectAnswer::isLikely()) counts only where no place holds the words more probably. Of equally good
/// goals (RouteOptions::tolerance) the one that is reached at the least cost. Throws Error as above, and
/// noAnswer when nothing matches.
WorldRoute routeInWorld(const WorldMap& world, int from, const std::string& to,
                        const RegionPreferences& preferences = {}, const RouteOptions& options = {});

/// For each object the way that routeInWorld() finds if nothing else is meant; absent where there is none.
/// Throws Error (unknownName) where there is no node `from`.
std::vector<std::optional<WorldRoute>> routesToObjects(const WorldMap& world, int from,
                                                       const RouteOptions& options = {});

/// The areas along a route, each once in a row; none in a map without areas.
std::vector<int> areasAlong(const WorldMap& world, const Route& route);

}  // namespace estancia
