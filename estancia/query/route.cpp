// SPDX-License-Identifier: Apache-2.0
#include "estancia/query/route.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/graph/adjacency_list.hpp>
#include <boost/graph/dijkstra_shortest_paths.hpp>

#include "estancia/core/error.hpp"
#include "estancia/query/ways.hpp"

namespace estancia {

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
  group
      .add("avoid-factor", &options.avoidFactor,
           "A meter in an area that is to be avoided costs as much as so many elsewhere.")
      .range(1, 1000)
      .why("A detour is taken while it is shorter than that; no area is ever out of reach.");
  group
      .add("prefer-factor", &options.preferFactor,
           "A meter in a preferred area costs as much as so many elsewhere.")
      .range(0.001, 1)
      .why("A way through it may be twice as long.");
  group
      .add("view-angle", &options.viewAngle,
           "An object whose middle is within this angle of where a frame looks was in its view [degrees].")
      .range(1, 90)
      .why("Usual depth cameras see 21° up and down, and more to the sides.");
  return group;
}

std::optional<Route> findRoute(const TopologicalMap& map, int from, int to, const RouteOptions& options) {
  map.getNode(to);
  const Ways ways(map, from, options);
  if (!ways.reaches(to)) return std::nullopt;
  return ways.routeTo(to);
}

Route getRoute(const TopologicalMap& map, int from, int to, const RouteOptions& options) {
  if (auto route = findRoute(map, from, to, options)) return *route;
  throw NoAnswerError(fmt::format("there is no way from node {} to node {}{}", from, to, whyNoWay(options)));
}

WordRoute routeToWords(const TopologicalMap& map, int from, const std::string& words,
                       const RouteOptions& options, WordGraphSource source) {
  validate(options);
  const Answers answers = ask(map, words, map.nodes.size(), source);
  const Ways ways(map, from, options);
  const PlaceAnswer* goal = chooseGoal(answers.places, options.tolerance, [&ways](const PlaceAnswer& answer) {
    return ways.costTo(answer.node);
  });
  if (goal == nullptr)
    throw NoAnswerError(
        fmt::format("no place with \"{}\" can be reached from node {}{}", words, from, whyNoWay(options)));
  return {*goal, answers, ways.routeTo(goal->node)};
}

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
