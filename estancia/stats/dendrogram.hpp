// Dendrogram: what hierarchical clustering has merged, and its cuts.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

namespace estancia {

/// n leaves and the n − 1 merges that make one cluster of them, as SciPy's linkage matrix Z.
class Dendrogram {
 public:
  /// Clusters are numbered: leaf i is i, merge k makes cluster n + k.
  struct Merge {
    /// left < right
    std::size_t left, right;
    /// The distance of the two clusters.
    double height;
    /// Items in the new cluster.
    std::size_t size;
  };

  /// `merges` in order of height, each of clusters that exist and are not yet merged. Throws Error
  /// (invalidInput) otherwise.
  Dendrogram(std::size_t leaves, std::vector<Merge> merges);

  std::size_t leaves() const { return leaves_; }
  const std::vector<Merge>& merges() const { return merges_; }

  /// The cluster number of each leaf (0, 1 … in order of first appearance) when merging stops once the
  /// smallest distance is above `distance`: items of one cluster have a cophenetic distance ≤ `distance`
  /// (fcluster's criterion "distance"). Throws Error (invalidInput) on NaN.
  std::vector<int> cutAt(double distance) const;

  /// Cuts the tree into exactly `clusters` clusters. Throws Error (invalidInput) unless 1 ≤ clusters ≤ leaves
  /// (0 without leaves).
  std::vector<int> cutInto(std::size_t clusters) const;

 private:
  std::vector<int> afterMerges(std::size_t count) const;

  std::size_t leaves_;
  std::vector<Merge> merges_;
};

}  // namespace estancia
