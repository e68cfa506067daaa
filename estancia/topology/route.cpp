// SPDX-License-Identifier: Apache-2.0
#include "estancia/topology/route.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/graph/adjacency_list.hpp>
#include <boost/graph/dijkstra_shortest_paths.hpp>
#include <limits>

#include "estancia/core/error.hpp"
#include "estancia/topology/places.hpp"

namespace estancia {
namespace {

constexpr double unreachable = std::numeric_limits<double>::max();  // as Boost.Graph marks it

/// The cheapest ways from one node to all others.
class Ways {
 public:
  Ways(const TopologicalMap& map, int from, const RouteOptions& options)
      : map_(map), costs_(map.nodes.size()), previous_(map.nodes.size()) {
    map.getNode(from);
    using Graph = boost::adjacency_list<boost::vecS, boost::vecS, boost::directedS, boost::no_property,
                                        boost::property<boost::edge_weight_t, double>>;
    const std::vector<Place> places = placesOf(map);
    metric_ =
        std::all_of(places.begin(), places.end(), [](const Place& p) { return p.position.has_value(); });
    Graph graph(map.nodes.size());
    for (const Transition& transition : map.transitions) {
      const std::size_t a = indexOf(map, transition.from), b = indexOf(map, transition.to);
      if (a == map.nodes.size() || b == map.nodes.size()) continue;
      const double cost = metric_ ? distanceBetween(*places[a].position, *places[b].position) : 1.0;
      boost::add_edge(a, b, cost, graph);
      if (options.bidirectional) boost::add_edge(b, a, cost, graph);
    }
    boost::dijkstra_shortest_paths(graph, indexOf(map, from),
                                   boost::predecessor_map(previous_.data()).distance_map(costs_.data()));
  }

  double costTo(int node) const { return costs_[indexOf(map_, node)]; }

  Route routeTo(int node) const {
    Route route{{}, costTo(node), metric_};
    std::size_t at = indexOf(map_, node);
    route.nodes.push_back(node);
    for (; previous_[at] != at; at = previous_[at]) route.nodes.push_back(map_.nodes[previous_[at]].id);
    std::reverse(route.nodes.begin(), route.nodes.end());
    return route;
  }

 private:
  const TopologicalMap& map_;
  std::vector<double> costs_;
  std::vector<std::size_t> previous_;
  bool metric_ = false;
};

std::string onlyForwards(const RouteOptions& options) {
  return options.bidirectional ? "; the robot never drove between their parts of the map"
                               : "; allow driving transitions backwards, too";
}

}  // namespace

OptionGroup declare(RouteOptions& options) {
  OptionGroup group("route", "How the way to a place is found.");
  group.add("bidirectional", &options.bidirectional, "Drive transitions backwards, too.")
      .why("Off where doors or lanes are one-way.");
  group
      .add("tolerance", &options.tolerance,
           "Places within this share of the best one's probability hold a word equally well: the nearest is "
           "taken.")
      .range(0, 1)
      .why("0 always drives to the most probable place.");
  return group;
}

std::optional<Route> findRoute(const TopologicalMap& map, int from, int to, const RouteOptions& options) {
  map.getNode(to);
  const Ways ways(map, from, options);
  if (ways.costTo(to) == unreachable) return std::nullopt;
  return ways.routeTo(to);
}

Route getRoute(const TopologicalMap& map, int from, int to, const RouteOptions& options) {
  if (auto route = findRoute(map, from, to, options)) return *route;
  throw NoAnswerError(
      fmt::format("there is no way from node {} to node {}{}", from, to, onlyForwards(options)));
}

WordRoute routeToWords(const TopologicalMap& map, int from, const std::string& words,
                       const RouteOptions& options) {
  validate(options);
  const Answers answers = ask(map, words, map.nodes.size());
  const Ways ways(map, from, options);
  const PlaceAnswer* goal = nullptr;
  double enough = 0;
  for (const PlaceAnswer& answer : answers.places) {  // most probable first
    if (answer.probability <= 0 || answer.probability < enough) break;
    const double cost = ways.costTo(answer.node);
    if (cost == unreachable) continue;
    if (goal == nullptr) enough = answer.probability * (1 - options.tolerance);
    if (goal == nullptr || cost < ways.costTo(goal->node)) goal = &answer;
  }
  if (goal == nullptr)
    throw NoAnswerError(fmt::format("no place with \"{}\" can be reached from node {}{}", words, from,
                                    onlyForwards(options)));
  return {*goal, answers, ways.routeTo(goal->node)};
}

}  // namespace estancia
