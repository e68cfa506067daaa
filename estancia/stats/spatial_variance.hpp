// Do images that look alike lie close together?
#pragma once

#include <array>
#include <span>

namespace estancia {

using Position = std::array<double, 3>;  ///< [m]

/// How far the members of clusters lie apart, as variances [m²]: mean squared distances to the mean position
/// of the cluster. One cluster of all gives the variance of the positions, singletons give 0.
struct SpatialVariance {
  double overClusters = 0;  ///< mean over the clusters, each as important as the next (thesis 4.5.2)
  double overItems = 0;     ///< mean over the items: a few stray singletons do not sweeten it
};

/// Throws Error when there are no items or the lengths differ. O(n log n).
SpatialVariance spatialVariance(std::span<const Position> positions, std::span<const int> clusters);

}  // namespace estancia
