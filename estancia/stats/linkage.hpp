// Hierarchical clustering, exact.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "estancia/core/memory.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/stats/dendrogram.hpp"
#include "estancia/stats/distance.hpp"
#include "estancia/stats/pairwise.hpp"

namespace estancia {

/// How far two clusters are apart.
enum class Linkage {
  single,    ///< as their nearest items
  complete,  ///< as their farthest items
  average,   ///< the mean over all pairs of items (UPGMA; thesis Algorithm 5.1)
  weighted,  ///< the mean of the distances of the two clusters last merged (WPGMA)
  ward  ///< how much their merger adds to the squared distances from the means: √(2 n m / (n + m)) · |means|
};

struct NamedLinkage {
  std::string name;
  Linkage linkage;
  std::string explanation;
};

const std::vector<NamedLinkage>& linkages();

/// Throws Error listing the known names.
Linkage getLinkage(std::string_view name);

/// How the compared vectors (comparedVectors()) of images are to be compared for this linkage: the distance's
/// own comparison, but for Ward's linkage, which adds up squares, the chord √(2 (1 − cos)) between unit
/// vectors instead of a cosine. Throws Error, naming what fits, for a distance that is not Euclidean with
/// Ward's linkage, and for σ-weighted distances: single images have no σ.
Comparison comparisonFor(const Distance& distance, Linkage linkage);

struct LinkageOptions {
  /// Items that each leaf stands for, when leaves are small clusters themselves; empty: one each. Average and
  /// Ward's linkage weigh by them. Distances are then those of the leaves' means.
  std::vector<std::size_t> sizes;
  Progress* progress = nullptr;  ///< told of merges
};

/// Merges the two nearest clusters until one is left. Exact, O(n²) time, in place: the nearest-neighbor
/// chain (Murtagh 1983; Müllner 2011), for single linkage Prim's spanning tree (Rohlf 1973; Gower and Ross
/// 1969). The same dendrogram as SciPy's linkage() on the same distances, ties included. Throws Error when a
/// distance is negative, above 1e100 or no number, or the sizes are not n numbers ≥ 1; Interrupted when the
/// user asks to stop.
Dendrogram link(CondensedDistances distances, Linkage linkage, const LinkageOptions& options = {});

/// Bytes that pairwiseDistances() and link() take for so many items.
std::uint64_t clusteringMemory(std::size_t items, std::size_t labels);

/// Throws Error, naming the streaming mode, when that is more than is available.
void requireClusteringMemory(std::size_t items, std::size_t labels,
                             std::uint64_t available = availableMemory());

}  // namespace estancia
