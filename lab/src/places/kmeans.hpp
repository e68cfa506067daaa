// K-means: clusters of points around their means, with k-means++ initialization.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "estancia/core/descriptor.hpp"

namespace estancia::experiments {

struct KMeansOptions {
  /// The most compact of so many clusterings is kept.
  std::size_t restarts = 5;
  std::uint64_t seed = 1;
  /// Maximum a clustering; 100 is OpenCV's maximum, a few dozen are usual.
  std::size_t iterations = 100;
};

/// Splits the rows into k clusters with small squared Euclidean distances to the clusters' means (Lloyd's
/// algorithm, begun by k-means++; Arthur and Vassilvitskii 2007). Returns the cluster of each row, 0 … k−1,
/// none of them empty. The result does not depend on the number of threads. Throws Error (invalidInput,
/// invalidOption) unless 1 ≤ k ≤ number of rows and there is a restart.
std::vector<int> kMeans(const DescriptorMatrix& rows, std::size_t k, const KMeansOptions& options = {});

}  // namespace estancia::experiments
