// Image tree: hierarchical clustering of a run's images, and where findZones() cuts it. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "estancia/stats/linkage.hpp"
#include "estancia/zones/zones.hpp"

namespace estancia {

/// The nearest other items of each item.
struct NearestItems {
  /// How many an item has: at most one less than there are items.
  std::size_t each = 0;
  /// N×each, row-major, nearest first, of equal ones the lower number.
  std::vector<std::uint32_t> nearest;
  /// N×each, how much a link counts; empty: all alike.
  std::vector<double> weights;
  /// N, how much an item is linked to itself; empty: not at all.
  std::vector<double> within;
};

/// How many neighbors suggestCut() wants of each of so many items: √N / 3, at least 3 (docs/how-to/zones.md).
std::size_t neighborsForCut(std::size_t items);

/// `count` of each. O(N²).
NearestItems findNeighbors(const CondensedDistances& distances, std::size_t count);

/// For items that are groups of so many images each: links weigh as if every image stood at its group's mean,
/// nearest to the others of its own group, then to those of the nearest groups, until it has `each`.
void weighBySize(NearestItems& neighbors, std::span<const std::size_t> sizes);

struct SuggestedCut {
  /// τ_d: merge up to here.
  double distance = 0;
  /// Modularity of the zones there, below 1.
  double modularity = 0;
  /// One sentence.
  std::string reason = {};
};

/// The cut whose zones keep neighbors together best, compared with chance: the partition of the dendrogram
/// with the largest modularity (Newman and Girvan 2004) of the graph that links each item and its nearest
/// neighbors, by half a link for each direction; of equal ones the fewest zones. Merges at the same height
/// are never separated. τ_d lies midway between the heights of the last merge done and the next. Items that
/// are all alike, or all neighbors, are one zone. O(N k log N). Throws Error (mismatch) for other items.
SuggestedCut suggestCut(const Dendrogram& dendrogram, const NearestItems& neighbors);

/// All merges of findZones(), and the neighbors that suggestCut() needs: to cut one tree at several heights.
struct ImageTree {
  Dendrogram dendrogram;
  NearestItems neighbors;
};
/// `cut` and `count` do not matter. Throws as findZones() does.
ImageTree linkImages(const DescriptorSequence& sequence, const ZoneOptions& options,
                     Progress& progress = Progress::none());

/// The distances of all pairs of images by options.distance, as options.linkage needs them. Throws as above.
CondensedDistances compareImages(const DescriptorSequence& sequence, const ZoneOptions& options,
                                 Progress& progress = Progress::none());

struct ZoneCut {
  /// Group of each leaf.
  std::vector<int> groups;
  /// τ_d.
  double distance = 0;
  /// One sentence.
  std::string reason;
};

/// Cuts at options.cut, into options.count groups (invalidOption: more than leaves), or at suggestCut().
ZoneCut cutTree(const Dendrogram& tree, const NearestItems& neighbors, const ZoneOptions& options);

}  // namespace estancia
