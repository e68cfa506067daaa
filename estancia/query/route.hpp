// Route planning: the cheapest way between places (Dijkstra), or to the place that holds a word.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "estancia/core/options.hpp"
#include "estancia/map_file/map.hpp"
#include "estancia/query/ask.hpp"

namespace estancia {

struct RouteOptions {
  bool bidirectional = true;
  double tolerance = 0.1;
  /// Cost factors of areas to avoid and to prefer, in routeInWorld().
  double avoidFactor = 5, preferFactor = 0.5;
  /// [degrees]
  double viewAngle = 20;
};
/// Declares the options and their ranges.
OptionGroup declare(RouteOptions& options);

struct Route {
  /// From start to goal; one node when they are the same.
  std::vector<int> nodes;
  /// Meters between node positions when every node has one, else transitions.
  double cost = 0;
  /// Whether the cost is in meters.
  bool metric = false;
};

/// The cheapest way (Dijkstra). Absent when there is none. Throws Error (unknownName) when a node does
/// not exist.
std::optional<Route> findRoute(const TopologicalMap& map, int from, int to, const RouteOptions& options = {});

/// Like findRoute(), but throws Error (noAnswer) when there is no way.
Route getRoute(const TopologicalMap& map, int from, int to, const RouteOptions& options = {});

struct WordRoute {
  PlaceAnswer goal;
  /// Match of the words.
  Meaning meaning;
  Route route;
};

/// The way to the place that holds `words` best among those that can be reached (see
/// RouteOptions::tolerance). Throws Error (noAnswer) when nothing matches, or no place with a probability
/// above 0 can be reached.
WordRoute routeToWords(const TopologicalMap& map, int from, const std::string& words,
                       const RouteOptions& options = {}, WordGraphSource source = nullptr);

}  // namespace estancia
