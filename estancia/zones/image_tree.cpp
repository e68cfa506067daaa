// SPDX-License-Identifier: Apache-2.0
#include "estancia/zones/image_tree.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/core/parallel.hpp"
#include "estancia/distances/distance.hpp"
#include "estancia/stats/label_scale.hpp"

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

struct Surroundings {
  /// N×L: weighted means of the descriptors around each image, its own included, as Eq. 4.3 is of a place:
  /// what the robot sees in one direction is joined to what it sees in the others.
  DescriptorMatrix descriptors;
  /// How many other images an image is pooled with: mean over the images of the sum of their weights.
  double others = 0;
};

/// Whether poses distinguish images.
bool isSpread(const std::vector<Frame>& frames, double reach) {
  const Pose* first = nullptr;
  for (const Frame& frame : frames) {
    if (!frame.pose) continue;
    if (first == nullptr) first = &*frame.pose;
    if (distanceBetween(*first, *frame.pose) > reach) return true;
  }
  return false;
}

Distance distanceOf(const DescriptorSequence& sequence, const ZoneOptions& options) {
  return getDistance(options.distance, sequence.vocabulary.layout().parts);
}

/// The way through the images up to each of them, 1 for one place.
std::vector<double> waysThrough(const DescriptorSequence& sequence, const ZoneOptions& options) {
  const Distance distance = distanceOf(sequence, options);
  const DescriptorMatrix vectors = comparedVectors(sequence.descriptors, distance);
  const std::size_t n = vectors.size();
  double unrelated = 0;  // mean of images half a run apart
  std::vector<double> ways(n);
  for (std::size_t i = 0; i < n; ++i) {
    unrelated +=
        compare(distance.comparison, vectors.row(i), vectors.row((i + n / 2) % n)) / static_cast<double>(n);
    if (i > 0) ways[i] = ways[i - 1] + compare(distance.comparison, vectors.row(i - 1), vectors.row(i));
  }
  if (unrelated > 0)  // .5 to 1 are as good on all sets
    for (double& way : ways) way /= 0.75 * unrelated;
  return ways;
}

/// Weights fall as a Gaussian of the distance between two poses, with a standard deviation of options.reach
/// [m]; where one of them has no pose, or all poses are nearer to each other than that, of the way through
/// the images between the two: the sum of the distances of neighbors in time, in units of the distance of
/// images that have nothing to do with each other. O(N² + N L ‧ images around one).
Surroundings poolSurroundings(const DescriptorSequence& sequence, const ZoneOptions& options,
                              Progress& progress) {
  const double reach = options.reach.value_or(0);
  const std::size_t n = sequence.frames.size(), labels = sequence.descriptors.labels();
  const bool inSpace = isSpread(sequence.frames, reach);
  const std::vector<double> ways = waysThrough(sequence, options);
  const auto weight = [&](std::size_t i, std::size_t j) {
    const auto &a = sequence.frames[i].pose, &b = sequence.frames[j].pose;
    const double far = inSpace && a && b ? distanceBetween(*a, *b) / reach : std::abs(ways[i] - ways[j]);
    return far < 3 ? std::exp(-far * far / 2) : 0;  // weights beyond are below .011
  };
  std::vector<std::vector<float>> pooled(n);
  std::vector<double> total(n);
  inParallel(n, options.threads, progress, "stopped before the surroundings were known", [&](std::size_t i) {
    std::vector<double> sum(labels);
    for (std::size_t j = 0; j < n; ++j) {
      const double w = weight(i, j);
      if (w == 0) continue;
      total[i] += w;
      const DescriptorView other = sequence.descriptors.row(j);
      for (std::size_t l = 0; l < labels; ++l) sum[l] += w * other[l];
    }
    for (const double value : sum) pooled[i].push_back(static_cast<float>(value / total[i]));
  });
  Surroundings result{DescriptorMatrix(labels)};
  result.descriptors.reserve(n);
  for (std::size_t i = 0; i < n; ++i) {
    result.descriptors.append(pooled[i]);
    result.others += (total[i] - 1) / static_cast<double>(n);
  }
  return result;
}

/// How the images are compared. Throws Error unless they can be.
Comparison requireComparable(const DescriptorSequence& sequence, const ZoneOptions& options) {
  const Comparison comparison = comparisonFor(distanceOf(sequence, options), getLinkage(options.linkage));
  for (std::size_t i = 0; i < sequence.frames.size(); ++i)
    requireProbabilities(sequence.descriptors.row(i), sequence.vocabulary.size(), sequence.frames[i].name);
  requireClusteringMemory(sequence.frames.size(), sequence.vocabulary.size());
  return comparison;
}

}  // namespace

std::size_t neighborsForCut(std::size_t items) {
  return std::max<std::size_t>(3, static_cast<std::size_t>(std::lround(std::sqrt(items) / 3)));
}

NearestItems findNeighbors(const CondensedDistances& distances, std::size_t count) {
  const std::size_t items = distances.items();
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

ZoneCut cutTree(const Dendrogram& tree, const NearestItems& neighbors, const ZoneOptions& options) {
  if (options.count) {
    if (*options.count > tree.leaves())
      fail(ErrorCode::invalidOption, "zones.count is {}; give 1 to {}, the number of images", *options.count,
           tree.leaves());
    std::vector<int> groups = tree.cutInto(*options.count);
    const std::size_t done = tree.leaves() - *options.count;
    return {std::move(groups), done == 0 ? 0 : tree.merges()[done - 1].height,
            *options.count == 1 ? "1 zone was asked for"
                                : fmt::format("{} zones were asked for", *options.count)};
  }
  if (options.cut) return {tree.cutAt(*options.cut), *options.cut, "it was given"};
  SuggestedCut suggested = suggestCut(tree, neighbors);
  return {tree.cutAt(suggested.distance), suggested.distance, std::move(suggested.reason)};
}

CondensedDistances compareImages(const DescriptorSequence& sequence, const ZoneOptions& options,
                                 Progress& progress) {
  const Comparison comparison = requireComparable(sequence, options);
  return pairwiseDistances(comparedVectors(sequence.descriptors, distanceOf(sequence, options)), comparison,
                           options.threads, progress);
}

ImageTree linkImages(const DescriptorSequence& sequence, const ZoneOptions& options, Progress& progress) {
  validate(options);
  if (sequence.frames.empty())
    throw Error(ErrorCode::insufficientData, "there are no images to make zones of; give at least one");
  std::size_t wanted = neighborsForCut(sequence.frames.size());
  const auto compared = [&] {
    if (options.reach.value_or(0) == 0) return compareImages(sequence, options, progress);
    requireComparable(sequence, options);
    Surroundings around = poolSurroundings(sequence, options, progress);
    // Each image is a neighbor of those that it is pooled with, whatever they show.
    wanted = std::max(wanted, static_cast<std::size_t>(std::lround(around.others)));
    return compareImages({sequence.vocabulary, sequence.model, sequence.frames, around.descriptors}, options,
                         progress);
  };
  CondensedDistances distances = compared();
  NearestItems neighbors = findNeighbors(distances, wanted);
  return {link(std::move(distances), getLinkage(options.linkage), {}, progress), std::move(neighbors)};
}

}  // namespace estancia
