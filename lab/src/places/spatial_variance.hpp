// Spatial variance of clusters: how far apart the positions of their members are.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>

namespace estancia::experiments {

/// [m]
using Position = std::array<double, 3>;

/// Variances [m²]: mean squared distances to the mean position of the cluster. One cluster of all items gives
/// the variance of the positions, singletons give 0.
struct SpatialVariance {
  /// Mean over the clusters, with equal weights (thesis 4.5.2).
  double overClusters = 0;
  /// Mean over the items: singletons hardly lower it.
  double overItems = 0;
};

/// Throws Error (mismatch) when there are no items or the lengths differ. O(n log n).
SpatialVariance spatialVariance(std::span<const Position> positions, std::span<const int> clusters);

}  // namespace estancia::experiments
