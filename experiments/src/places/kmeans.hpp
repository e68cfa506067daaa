// k-means clustering.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "estancia/core/descriptor.hpp"

namespace estancia::experiments {

struct KMeansOptions {
  std::size_t restarts = 5;  ///< the tightest of so many clusterings is kept; more: less left to chance
  std::uint64_t seed = 1;
};

/// Splits the rows into k clusters with small squared Euclidean distances to the clusters' means (Lloyd's
/// algorithm, begun by k-means++; Arthur and Vassilvitskii 2007). Returns each row's cluster, 0 … k−1, none
/// of them empty. The same rows and options give the same answer, whatever the number of threads.
/// Throws Error unless 1 ≤ k ≤ number of rows.
std::vector<int> kMeans(const DescriptorMatrix& rows, std::size_t k, const KMeansOptions& options = {});

}  // namespace estancia::experiments
