#include "estancia/topology/map.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
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

std::optional<std::array<double, 3>> TopologicalMap::positionOf(int node) const {
  std::array<double, 3> sum{};
  std::size_t count = 0;
  for (const MappedFrame& frame : frames)
    if (frame.node == node && frame.pose) {
      sum[0] += frame.pose->x;
      sum[1] += frame.pose->y;
      sum[2] += frame.pose->z;
      ++count;
    }
  if (count == 0) return std::nullopt;
  for (double& value : sum) value /= static_cast<double>(count);
  return sum;
}

std::string TopologicalMap::roomOf(int node) const {
  std::map<std::string, std::size_t> votes;
  for (const MappedFrame& frame : frames)
    if (frame.node == node && !frame.room.empty()) ++votes[frame.room];
  const auto best = std::max_element(votes.begin(), votes.end(),
                                     [](const auto& a, const auto& b) { return a.second < b.second; });
  return best == votes.end() ? "" : best->first;
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
