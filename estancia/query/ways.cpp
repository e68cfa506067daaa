// SPDX-License-Identifier: Apache-2.0
#include "estancia/query/ways.hpp"

#include <algorithm>
#include <boost/graph/adjacency_list.hpp>
#include <boost/graph/dijkstra_shortest_paths.hpp>

namespace estancia {

Ways::Ways(const TopologicalMap& map, int from, const RouteOptions& options, std::span<const double> factors)
    : map_(map), places_(placesOf(map)), costs_(map.nodes.size()), previous_(map.nodes.size()) {
  map.getNode(from);
  using Graph = boost::adjacency_list<boost::vecS, boost::vecS, boost::directedS, boost::no_property,
                                      boost::property<boost::edge_weight_t, double>>;
  metric_ =
      std::all_of(places_.begin(), places_.end(), [](const Place& p) { return p.position.has_value(); });
  Graph graph(map.nodes.size());
  for (const Transition& transition : map.transitions) {
    const std::size_t a = indexOf(map, transition.from), b = indexOf(map, transition.to);
    if (a == map.nodes.size() || b == map.nodes.size()) continue;
    const double factor = factors.empty() ? 1 : (factors[a] + factors[b]) / 2;
    boost::add_edge(a, b, lengthBetween(a, b) * factor, graph);
    if (options.bidirectional) boost::add_edge(b, a, lengthBetween(a, b) * factor, graph);
  }
  constexpr double infinite = std::numeric_limits<double>::infinity();
  boost::dijkstra_shortest_paths(
      graph, indexOf(map, from),
      boost::predecessor_map(previous_.data()).distance_map(costs_.data()).distance_inf(infinite));
}

double Ways::lengthBetween(std::size_t a, std::size_t b) const {
  return metric_ ? distanceBetween(*places_[a].position, *places_[b].position) : 1;
}

double Ways::costTo(int node) const {
  return costs_[indexOf(map_, node)];
}

Route Ways::routeTo(int node) const {
  std::vector<std::size_t> steps{indexOf(map_, node)};
  while (previous_[steps.back()] != steps.back()) steps.push_back(previous_[steps.back()]);
  std::reverse(steps.begin(), steps.end());
  Route route{{}, 0, metric_};
  for (std::size_t i = 0; i < steps.size(); ++i) {
    route.nodes.push_back(map_.nodes[steps[i]].id);
    if (i > 0) route.cost += lengthBetween(steps[i - 1], steps[i]);
  }
  return route;
}

std::string whyNoWay(const RouteOptions& options) {
  return options.bidirectional ? "; the robot never drove between their parts of the map"
                               : "; allow driving transitions backwards, too";
}

}  // namespace estancia
