// Ways: the cheapest ways from one place to all others (Dijkstra). Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <span>
#include <string>
#include <vector>

#include "estancia/map_file/places.hpp"
#include "estancia/query/route.hpp"

namespace estancia {

class Ways {
 public:
  /// `factors`: what a meter, or half a transition, costs in each place, > 0, in the order of map.nodes;
  /// empty: 1. An edge lies half in the place it leaves, half in the one it enters. The map must outlive it.
  /// Throws Error (unknownName) when there is no such node.
  Ways(const TopologicalMap& map, int from, const RouteOptions& options,
       std::span<const double> factors = {});

  /// With the factors; infinite where the node cannot be reached.
  double costTo(int node) const { return costs_[indexOf(map_, node)]; }
  bool reaches(int node) const { return costTo(node) < std::numeric_limits<double>::infinity(); }
  /// Its cost is without the factors. The node must be reached.
  Route routeTo(int node) const;

 private:
  double lengthBetween(std::size_t a, std::size_t b) const;

  const TopologicalMap& map_;
  std::vector<Place> places_;
  std::vector<double> costs_;
  std::vector<std::size_t> previous_;
  bool metric_ = false;
};

/// From `goals`, the most probable first, the one of min cost among those whose probability is within
/// `tolerance` of the best that can be reached (RouteOptions::tolerance). nullptr when none with a
/// probability above 0 can be. `costOf(goal)` is infinite where it cannot.
template <class Goal, class Cost>
const Goal* chooseGoal(const std::vector<Goal>& goals, double tolerance, const Cost& costOf) {
  const Goal* chosen = nullptr;
  double enough = 0, least = 0;
  for (const Goal& goal : goals) {
    if (goal.probability <= 0 || goal.probability < enough) break;
    const double cost = costOf(goal);
    if (!(cost < std::numeric_limits<double>::infinity())) continue;
    if (chosen == nullptr) enough = goal.probability * (1 - tolerance);
    if (chosen == nullptr || cost < least) chosen = &goal, least = cost;
  }
  return chosen;
}

/// Why there may be no way: ends a message.
std::string whyNoWay(const RouteOptions& options);

}  // namespace estancia
