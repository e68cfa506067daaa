// What hierarchical clustering gives: the tree of merges, and its cuts.
#pragma once

#include <cstddef>
#include <vector>

namespace estancia {

/// n leaves and the n − 1 merges that make one cluster of them, as SciPy's linkage matrix Z tells it.
class Dendrogram {
 public:
  /// Clusters are numbered: leaf i is i, merge k makes cluster n + k.
  struct Merge {
    std::size_t left, right;  ///< left < right
    double height;            ///< the distance at which the two became one
    std::size_t size;         ///< items in the new cluster
  };

  /// `merges` in order of height, each of clusters that exist and are not yet merged. Throws Error otherwise.
  Dendrogram(std::size_t leaves, std::vector<Merge> merges);

  std::size_t leaves() const { return leaves_; }
  const std::vector<Merge>& merges() const { return merges_; }

  /// The cluster number of each leaf (0, 1 … in order of first appearance) when merging stops once the
  /// smallest distance is above `distance`: items of one cluster have a cophenetic distance ≤ `distance`
  /// (fcluster's criterion "distance"). Throws Error when it is not a number.
  std::vector<int> cutAt(double distance) const;

  /// The same for exactly `clusters` clusters. Throws Error unless 1 ≤ clusters ≤ leaves (0 when there are
  /// none).
  std::vector<int> cutInto(std::size_t clusters) const;

 private:
  std::vector<int> afterMerges(std::size_t count) const;

  std::size_t leaves_;
  std::vector<Merge> merges_;
};

}  // namespace estancia
