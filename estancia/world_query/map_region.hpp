// Map region: a part of a map that a robot behaves differently in (thesis 5.6), by its name.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "estancia/query/ask.hpp"
#include "estancia/query/route.hpp"
#include "estancia/world_file/world_map.hpp"

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

/// Throws Error (unknownName) where nothing has that name.
RegionCosts regionCosts(const WorldMap& world, const RegionPreferences& preferences,
                        const RouteOptions& options, WordGraphSource source = nullptr);

}  // namespace estancia
