// SPDX-License-Identifier: Apache-2.0
#include "estancia/zones/cut.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "estancia/core/fail.hpp"

namespace estancia {
namespace {

/// The links of all items, listed at both their ends; half of a weight belongs to each end.
struct LinkGraph {
  struct Link {
    std::uint32_t other;
    double weight;
  };
  std::vector<std::vector<Link>> links;
  std::vector<double> strength;  // one an item: the weights at its end
  double total = 0, within = 0;  // W, and the part of it that links items to themselves
};

LinkGraph linkGraph(std::size_t items, const NearestItems& neighbors) {
  LinkGraph graph{.links = std::vector<std::vector<LinkGraph::Link>>(items),
                  .strength = std::vector<double>(items)};
  for (std::uint32_t i = 0; i < items; ++i) {
    if (!neighbors.within.empty()) {
      graph.strength[i] += neighbors.within[i];
      graph.within += neighbors.within[i];
    }
    for (std::size_t k = i * neighbors.each; k < (i + 1) * neighbors.each; ++k) {
      const double weight = neighbors.weights.empty() ? 1 : neighbors.weights[k];
      const std::uint32_t j = neighbors.nearest[k];
      graph.links[i].push_back({j, weight});
      graph.links[j].push_back({i, weight});
      graph.strength[i] += weight / 2;
      graph.strength[j] += weight / 2;
      graph.total += weight;
    }
  }
  graph.total += graph.within;
  return graph;
}

/// Modularity after 0, 1 … N−1 merges: Q = Σ_c (A_cc / W − a_c²) over the parts c, where A_cc are the weights
/// inside, each link counted from both its ends, a_c = A_c / W the share of all weights at its items, and W
/// the sum of all weights. Merging i and j changes it by ΔQ = 2·(A_ij / W − a_i a_j), where A_ij are the
/// weights between them, counted from one end (Clauset, Newman and Moore 2004).
std::vector<double> modularities(const Dendrogram& tree, const NearestItems& neighbors) {
  struct Part {
    std::vector<std::uint32_t> items;
    double share = 0;  // a_c
  };
  const std::size_t items = tree.leaves();
  const LinkGraph graph = linkGraph(items, neighbors);
  std::vector<Part> parts(items);
  std::vector<std::uint32_t> partOf(items);
  double q = graph.total > 0 ? graph.within / graph.total : 0;
  for (std::uint32_t i = 0; i < items; ++i) {
    parts[i] = {{i}, graph.strength[i] / graph.total};
    partOf[i] = i;
    q -= parts[i].share * parts[i].share;
  }
  std::vector<double> curve{q};
  for (const Dendrogram::Merge& merge : tree.merges()) {
    Part small = std::move(parts[merge.left]), large = std::move(parts[merge.right]);
    if (small.items.size() > large.items.size()) std::swap(small, large);
    const std::uint32_t name = partOf[large.items.front()];
    double between = 0;  // 2 A_ij
    for (const std::uint32_t item : small.items)
      for (const LinkGraph::Link& link : graph.links[item])
        if (partOf[link.other] == name) between += link.weight;
    q += between / graph.total - 2 * small.share * large.share;  // ΔQ
    for (const std::uint32_t item : small.items) partOf[item] = name;
    large.items.insert(large.items.end(), small.items.begin(), small.items.end());
    large.share += small.share;
    parts.push_back(std::move(large));
    curve.push_back(q);
  }
  return curve;
}

}  // namespace

std::size_t neighborsForCut(std::size_t items) {
  return std::max<std::size_t>(3, static_cast<std::size_t>(std::lround(std::sqrt(items) / 3)));
}

NearestItems findNeighbors(const CondensedDistances& distances, std::size_t count) {
  const std::size_t items = distances.items();
  if (count == 0) count = neighborsForCut(items);
  NearestItems neighbors;
  neighbors.each = std::min(count, items - std::min<std::size_t>(items, 1));
  const std::size_t each = neighbors.each;
  if (each == 0) return neighbors;
  neighbors.nearest.resize(items * each);
  std::vector<double> near(items * each, std::numeric_limits<double>::infinity());
  // Others are offered to an item in ascending order, so that of equally near ones the first stays.
  const auto offer = [&](std::size_t item, std::size_t other, double distance) {
    std::size_t at = (item + 1) * each - 1;
    if (!(distance < near[at])) return;
    for (; at > item * each && distance < near[at - 1]; --at) {
      near[at] = near[at - 1];
      neighbors.nearest[at] = neighbors.nearest[at - 1];
    }
    near[at] = distance;
    neighbors.nearest[at] = static_cast<std::uint32_t>(other);
  };
  std::span<const double> rest = distances.values();
  for (std::size_t i = 0; i + 1 < items; ++i) {
    for (std::size_t j = i + 1; j < items; ++j) {
      const double distance = rest[j - i - 1];
      offer(i, j, distance);
      offer(j, i, distance);
    }
    rest = rest.subspan(items - i - 1);
  }
  return neighbors;
}

void weighBySize(NearestItems& neighbors, std::span<const std::size_t> sizes) {
  const std::size_t each = neighbors.each;
  if (neighbors.nearest.size() != sizes.size() * each)
    fail(ErrorCode::mismatch, "{} neighbors do not belong to {} groups", neighbors.nearest.size(),
         sizes.size());
  neighbors.within.clear();
  neighbors.weights.assign(neighbors.nearest.size(), 0);
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    std::size_t wanted = each - std::min(each, sizes[i] - 1);
    neighbors.within.push_back(static_cast<double>(sizes[i] * (each - wanted)));
    for (std::size_t k = i * each; k < (i + 1) * each && wanted > 0; ++k) {
      const std::size_t found = std::min(wanted, sizes[neighbors.nearest[k]]);
      neighbors.weights[k] = static_cast<double>(sizes[i] * found);
      wanted -= found;
    }
  }
}

SuggestedCut suggestCut(const Dendrogram& dendrogram, const NearestItems& neighbors) {
  const auto& merges = dendrogram.merges();
  if (neighbors.nearest.size() != dendrogram.leaves() * neighbors.each)
    fail(ErrorCode::mismatch, "{} neighbors do not belong to a dendrogram of {} leaves",
         neighbors.nearest.size(), dendrogram.leaves());
  const std::vector<double> curve = modularities(dendrogram, neighbors);
  // All in one: always a cut, whose modularity is 0 but for rounding.
  SuggestedCut best{merges.empty() ? 0 : merges.back().height, 0,
                    "the images are too similar, or too few, for several zones"};
  for (std::size_t done = merges.size(); done-- > 0;) {
    const double below = done == 0 ? 0 : merges[done - 1].height, above = merges[done].height;
    constexpr double sameHeight = 1e-6, rounding = 1e-9;
    if (above > below * (1 + sameHeight) && curve[done] > best.modularity + rounding)
      best = {below + (above - below) / 2, curve[done],
              fmt::format("modularity is largest there ({:.2f}; graph of the {} nearest neighbors)",
                          curve[done], neighbors.each)};
  }
  return best;
}

}  // namespace estancia
