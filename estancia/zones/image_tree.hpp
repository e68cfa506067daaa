// Image tree: hierarchical clustering of a run's images, and where findZones() cuts it. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "estancia/stats/linkage.hpp"
#include "estancia/zones/cut.hpp"
#include "estancia/zones/zones.hpp"

namespace estancia {

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

/// Cuts at options.cut, into options.count groups, or at suggestCut(). Throws Error (invalidOption) for more
/// groups than leaves.
ZoneCut cutTree(const Dendrogram& tree, const NearestItems& neighbors, const ZoneOptions& options);

}  // namespace estancia
