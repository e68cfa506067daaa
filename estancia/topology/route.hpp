// Ways through the map: from place to place, and from a place to a word.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "estancia/topology/ask.hpp"
#include "estancia/topology/map.hpp"

namespace estancia {

struct RouteOptions {
  bool bidirectional = true;  ///< drive transitions backwards, too; false where doors or lanes are one-way
  /// Places whose probability is within this share of the best one's hold the word equally well: the nearest
  /// of them is the goal. 0: always the most probable place.
  double tolerance = 0.1;
};

struct Route {
  std::vector<int> nodes;  ///< from start to goal; one node when they are the same
  double cost = 0;         ///< meters between node positions when every node has one, else transitions
  bool metric = false;     ///< whether the cost is in meters
};

/// The cheapest way (Dijkstra). Absent when there is none. Throws Error when a node does not exist.
std::optional<Route> findRoute(const TopologicalMap& map, int from, int to, const RouteOptions& options = {});

/// As findRoute(), but throws Error when there is no way.
Route getRoute(const TopologicalMap& map, int from, int to, const RouteOptions& options = {});

struct WordRoute {
  PlaceAnswer goal;
  Meaning meaning;  ///< what the words were taken for
  Route route;
};

/// The way to the place that holds `words` best among those that can be reached (see
/// RouteOptions::tolerance). Throws Error when nothing matches, or no place with a probability above 0 can
/// be reached.
WordRoute routeToWords(const TopologicalMap& map, int from, const std::string& words,
                       const RouteOptions& options = {});

}  // namespace estancia
