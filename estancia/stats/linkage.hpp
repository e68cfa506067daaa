// Hierarchical clustering, exact: distances of all pairs, linkage, dendrogram and its cuts.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/memory.hpp"
#include "estancia/core/options.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/distances/distance.hpp"
#include "estancia/stats/dendrogram.hpp"

namespace estancia {

/// A symmetric matrix of n×n distances with a zero diagonal, condensed as SciPy's pdist gives it: d(0, 1),
/// d(0, 2) … d(0, n−1), d(1, 2) … Float64, since linkage averages in place: 8 · n (n − 1) / 2 bytes.
class CondensedDistances {
 public:
  /// Not initialized. Throws Error (tooLarge) without such memory.
  explicit CondensedDistances(std::size_t items);

  static std::uint64_t bytes(std::size_t items);

  std::size_t items() const { return items_; }
  std::span<double> values() & { return {values_.get(), size_}; }
  std::span<const double> values() const& { return {values_.get(), size_}; }
  std::span<const double> values() const&& = delete;  // they would dangle
  /// Distance of two different items.
  double operator()(std::size_t i, std::size_t j) const { return values_[i < j ? place(i, j) : place(j, i)]; }
  /// Distances of item i to i+1 … n−1.
  double* after(std::size_t i) { return values_.get() + (i + 1 < items_ ? place(i, i + 1) : size_); }

 private:
  std::size_t place(std::size_t i, std::size_t j) const { return i * (2 * items_ - i - 1) / 2 + j - i - 1; }
  struct Free {
    void operator()(double* values) const { std::free(values); }
  };
  std::size_t items_, size_;
  std::unique_ptr<double[], Free> values_;
};

/// compare(comparison, …) of all pairs of rows (see comparedVectors()), in float32 up to rounding: equal rows
/// have distance 0 exactly, none is negative. O(N² L). `threads` 0: one a usable core; the distances do not
/// depend on them. Throws Error (invalidInput) when a value is not finite; Interrupted.
CondensedDistances pairwiseDistances(const DescriptorMatrix& rows, Comparison comparison, int threads = 0,
                                     Progress& progress = Progress::none());

/// The distance of two clusters.
enum class Linkage {
  /// Distance of their nearest items.
  single,
  /// Distance of their farthest items.
  complete,
  /// The mean over all pairs of items (UPGMA; thesis Algorithm 5.1).
  average,
  /// The mean of the distances to the two clusters last merged (WPGMA).
  weighted,
  /// How much a merge increases the squared distances from the means: √(2 n m / (n + m)) · |mean − mean'|.
  ward
};

/// The names of Linkage.
Choices linkages();

/// Throws Error (unknownName).
Linkage getLinkage(std::string_view name);

/// The comparison of images (of their comparedVectors()) for this linkage: that of the distance, but for
/// Ward's linkage, which adds up squares, the chord √(2 (1 − cos)) between unit vectors instead of a cosine.
/// Throws Error (invalidOption), with the distances that fit, for Ward's linkage with a distance that is not
/// Euclidean, and for σ-weighted distances: single images have no σ.
Comparison comparisonFor(const Distance& distance, Linkage linkage);

/// Merges the two nearest clusters until one is left. Exact, O(n²) time, in place: the nearest-neighbor chain
/// (Murtagh 1983; Müllner 2011), for single linkage Prim's spanning tree (Rohlf 1973; Gower and Ross 1969).
/// The dendrogram equals that of SciPy's linkage() on these distances, ties included. `sizes` are the items
/// of leaves that are clusters themselves, with the distances of their means (empty: one item each); average
/// and Ward's linkage weight by them. Throws Error (invalidInput) when a distance is negative, above 1e100 or
/// NaN, or the sizes are not n numbers ≥ 1; Interrupted.
Dendrogram link(CondensedDistances distances, Linkage linkage, const std::vector<std::size_t>& sizes = {},
                Progress& progress = Progress::none());

/// Bytes that pairwiseDistances() and link() need.
std::uint64_t clusteringMemory(std::size_t items, std::size_t labels);

/// Throws Error (tooLarge) when that is more than `available` bytes.
void requireClusteringMemory(std::size_t items, std::size_t labels,
                             std::uint64_t available = availableMemory());

}  // namespace estancia
