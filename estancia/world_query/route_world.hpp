// Route planning in a world: to a place, an area, an object, or to words; areas are avoided or preferred.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>
#include <vector>

#include "estancia/query/route.hpp"
#include "estancia/world_file/world_map.hpp"
#include "estancia/world_query/ask_world.hpp"

namespace estancia {

/// Regions to avoid, and regions to prefer. Each is an area (its number or name, as getArea()), else a room
/// of places (true or predicted), else words: the places that are likely to hold them
/// (PlaceAnswer::isLikely()) and hold them more than the map's mean.
struct RegionPreferences {
  std::vector<std::string> avoid = {}, prefer = {};
};

/// Either areas of the floor, or places.
struct MapRegion {
  /// Name in the question.
  std::string name;
  std::vector<int> areas = {};
  /// In the order of map.nodes; empty where it is areas.
  std::vector<bool> places = {};
  /// Labels matched by the words; empty if they are areas, or places of that room.
  Meaning meaning = {};

  /// `place`: an index into map.nodes; `area`: -1 for none.
  bool holds(std::size_t place, int area) const;
};

/// Cost of a meter by region.
struct RegionCosts {
  std::vector<MapRegion> avoid = {}, prefer = {};
  double avoidFactor = 1, preferFactor = 1;

  /// RouteOptions::avoidFactor and preferFactor, both where regions overlap; each once.
  double at(std::size_t place, int area) const;
};

/// A stretch of a way in one place and one area.
struct WayPiece {
  /// Index into map.nodes.
  std::size_t place = 0;
  /// -1 for none.
  int area = -1;
  /// [m]
  double length = 0;
};

/// Where a way goes on the floor, in the floor's axes [m].
struct DrivenWay {
  std::vector<cv::Point2d> points;
  /// [m]
  double length = 0;
  /// Pieces of that length, in order; one without length where it does not move.
  std::vector<WayPiece> pieces = {};
};

/// A pose on the floor, in the floor's axes [m]; in a map with z up these are x and y.
struct ViewPose {
  double x = 0, y = 0;
  /// Towards the object, counter-clockwise from the x axis [rad].
  double yaw = 0;
  /// The frame that was taken there.
  std::size_t frame = 0;
  /// To the object's middle, on the floor [m].
  double distance = 0;
};

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
