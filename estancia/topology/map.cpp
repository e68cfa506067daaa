#include "estancia/topology/map.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <numeric>

#include "estancia/core/error.hpp"

namespace estancia {

const Node* TopologicalMap::findNode(int id) const {
  const auto found = std::lower_bound(nodes.begin(), nodes.end(), id,
                                      [](const Node& node, int wanted) { return node.id < wanted; });
  return found != nodes.end() && found->id == id ? &*found : nullptr;
}

const Node& TopologicalMap::getNode(int id) const {
  if (const Node* node = findNode(id)) return *node;
  constexpr std::size_t shown = 40;
  std::vector<int> ids;
  for (const Node& node : nodes) ids.push_back(node.id);
  const bool cut = ids.size() > shown;
  if (cut) ids.resize(shown);
  throw Error(
      fmt::format("there is no node {}; the map has nodes {}{}", id, fmt::join(ids, " "), cut ? " …" : ""));
}

std::string toString(DecisionKind kind) {
  switch (kind) {
    case DecisionKind::start:
      return "start";
    case DecisionKind::join:
      return "join";
    case DecisionKind::revisit:
      return "revisit";
    case DecisionKind::split:
      return "split";
  }
  throw Error("a decision of unknown kind");
}

std::vector<std::size_t> bestLabels(const Node& node, std::size_t count) {
  std::vector<std::size_t> order(node.mean.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  count = std::min(count, order.size());
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count), order.end(),
                    [&](std::size_t a, std::size_t b) {
                      return node.mean[a] != node.mean[b] ? node.mean[a] > node.mean[b] : a < b;
                    });
  order.resize(count);
  return order;
}

}  // namespace estancia
