#include "estancia/zones/cut.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "estancia/core/error.hpp"

namespace estancia {
namespace {

/// Modularity after 0, 1 … N−1 merges: Q = Σ_c (A_cc / W − (A_c / W)²) over the parts c, where A_cc are the
/// weights inside, each link counted from both its ends, A_c all weights at its items and W all there are.
std::vector<double> modularities(const Dendrogram& tree, const NearestItems& neighbors) {
  struct Part {
    std::vector<std::uint32_t> items;
    double share = 0;  ///< A_c / W
  };
  const std::size_t items = tree.leaves();
  struct Link {
    std::uint32_t other;
    double weight;
  };
  std::vector<std::vector<Link>> linked(items);  // every link at both its ends, half of its weight at each
  std::vector<double> at(items);
  double links = 0, within = 0;
  for (std::uint32_t i = 0; i < items; ++i) {
    if (!neighbors.within.empty()) {
      at[i] += neighbors.within[i];
      within += neighbors.within[i];
    }
    for (std::size_t k = i * neighbors.each; k < (i + 1) * neighbors.each; ++k) {
      const double weight = neighbors.weights.empty() ? 1 : neighbors.weights[k];
      const std::uint32_t j = neighbors.nearest[k];
      linked[i].push_back({j, weight});
      linked[j].push_back({i, weight});
      at[i] += weight / 2;
      at[j] += weight / 2;
      links += weight;
    }
  }
  links += within;
  std::vector<Part> parts(items);
  std::vector<std::uint32_t> partOf(items);
  double q = links > 0 ? within / links : 0;
  for (std::uint32_t i = 0; i < items; ++i) {
    parts[i] = {{i}, at[i] / links};
    partOf[i] = i;
    q -= parts[i].share * parts[i].share;
  }
  std::vector<double> curve{q};
  for (const Dendrogram::Merge& merge : tree.merges()) {
    Part small = std::move(parts[merge.left]), large = std::move(parts[merge.right]);
    if (small.items.size() > large.items.size()) std::swap(small, large);
    const std::uint32_t name = partOf[large.items.front()];
    double between = 0;
    for (const std::uint32_t item : small.items)
      for (const Link& link : linked[item])
        if (partOf[link.other] == name) between += link.weight;
    q += between / links - 2 * small.share * large.share;
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
    throw Error(
        fmt::format("{} neighbors do not belong to {} groups", neighbors.nearest.size(), sizes.size()));
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
    throw Error(fmt::format("{} neighbors do not belong to a dendrogram of {} leaves",
                            neighbors.nearest.size(), dendrogram.leaves()));
  const std::vector<double> curve = modularities(dendrogram, neighbors);
  // All in one: always a cut, whose modularity is 0 but for rounding.
  SuggestedCut best{merges.empty() ? 0 : merges.back().height, 0,
                    "the images are too alike, or too few, to be parted"};
  for (std::size_t done = merges.size(); done-- > 0;) {
    const double below = done == 0 ? 0 : merges[done - 1].height, above = merges[done].height;
    constexpr double sameHeight = 1e-6, rounding = 1e-9;
    if (above > below * (1 + sameHeight) && curve[done] > best.modularity + rounding)
      best = {below + (above - below) / 2, curve[done],
              fmt::format("images and their {} nearest stay together best there, modularity {:.2f}",
                          neighbors.each, curve[done])};
  }
  return best;
}

}  // namespace estancia
