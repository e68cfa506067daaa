// Route planning in a world: to a place, an area, an object, or to words; areas are avoided or preferred.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "estancia/query/route.hpp"
#include "estancia/world_file/world_map.hpp"
#include "estancia/world_query/ask_world.hpp"
#include "estancia/world_query/driven_way.hpp"
#include "estancia/world_query/map_region.hpp"
#include "estancia/world_query/view_pose.hpp"

namespace estancia {

/// A region to be avoided that the way leads through all the same.
struct CrossedRegion {
  enum class Why {
    goal,
    start,
    /// There is no way around, or it is longer by more than RouteOptions::avoidFactor.
    detour
  };
  /// Name in the question.
  std::string name;
  /// Path length inside this region [m]; 0 if unknown.
  double length = 0;
  Why why = Why::detour;
};

struct WorldRoute {
  /// The places along the way; its cost is the length of `driven` where there is that.
  Route route;
  /// The areas along it, each once in a row; none in a map without areas.
  std::vector<int> areas = {};
  std::vector<CrossedRegion> crossed = {};
  /// Regions to avoid and prefer, as they were understood.
  RegionCosts regions = {};
  /// The area that the goal names; -1 for none.
  int area = -1;
  /// The object at the goal, and where to stand and look: in the last place of the route.
  std::optional<ObjectAnswer> object = {};
  std::optional<ViewPose> pose = {};
  /// The place that holds the words, where no area or object was found.
  std::optional<PlaceAnswer> place = {};
  /// Match of the words.
  Meaning meaning = {};
  /// The way on the floor, to the pose where there is one, else to the middle of a place. Absent without
  /// poses, or where the frames between were not driven one after the other: then the way is that over the
  /// transitions between places.
  std::optional<DrivenWay> driven = {};
};

/// The cheapest way to a node. `source`: installedWordGraph to understand words that no label has
/// (findMeaning()). Throws Error: unknownName when a node or a region does not exist; noAnswer when there is
/// no way.
WorldRoute routeInWorld(const WorldMap& world, int from, int to, const RegionPreferences& preferences = {},
                        const RouteOptions& options = {}, WordGraphSource source = nullptr);

/// The way to the areas of that name, or, where the words mean nothing else, of a name that holds them; else
/// to the object that the words mean, to a pose that faces it (ViewPoses); else to the place that holds them
/// (routeToWords()). An object that is hardly likely to be meant (ObjectAnswer::isLikely()) counts only where
/// no place holds the words more probably. Among equally good goals (RouteOptions::tolerance) the one that is
/// reached at the least cost. Throws Error as above, and noAnswer when nothing matches.
WorldRoute routeInWorld(const WorldMap& world, int from, const std::string& to,
                        const RegionPreferences& preferences = {}, const RouteOptions& options = {},
                        WordGraphSource source = nullptr);

/// For each object the way that routeInWorld() finds if nothing else is meant; absent where there is none.
/// Throws Error (unknownName) where there is no node `from`.
std::vector<std::optional<WorldRoute>> routesToObjects(const WorldMap& world, int from,
                                                       const RouteOptions& options = {});

/// Routes to each area.
std::vector<std::optional<WorldRoute>> routesToEachArea(const WorldMap& world, int from,
                                                        const RouteOptions& options = {});

/// A sentence about it.
std::string crossedText(const CrossedRegion& crossed, const RouteOptions& options);

}  // namespace estancia
