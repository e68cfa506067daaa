#include "estancia/stats/dendrogram.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "estancia/core/error.hpp"

namespace estancia {

Dendrogram::Dendrogram(std::size_t leaves, std::vector<Merge> merges)
    : leaves_(leaves), merges_(std::move(merges)) {
  if (merges_.size() + 1 != std::max<std::size_t>(leaves_, 1))
    throw Error(fmt::format("a dendrogram of {} leaves has not {} merges", leaves_, merges_.size()));
  std::vector<char> merged(leaves_ + merges_.size(), 0);
  for (std::size_t k = 0; k < merges_.size(); ++k) {
    const Merge& merge = merges_[k];
    const bool inOrder = k == 0 ? merge.height >= 0 : merge.height >= merges_[k - 1].height;
    if (!inOrder || merge.left >= merge.right || merge.right >= leaves_ + k || merged[merge.left] != 0 ||
        merged[merge.right] != 0)
      throw Error(fmt::format(
          "merge {} of a dendrogram joins {} and {} at {}, which does not follow from those before", k,
          merge.left, merge.right, merge.height));
    merged[merge.left] = merged[merge.right] = 1;
  }
}

std::vector<int> Dendrogram::cutAt(double distance) const {
  if (std::isnan(distance)) throw Error("a dendrogram is cut at a distance; give a number");
  const auto above = std::partition_point(
      merges_.begin(), merges_.end(), [distance](const Merge& merge) { return merge.height <= distance; });
  return afterMerges(static_cast<std::size_t>(above - merges_.begin()));
}

std::vector<int> Dendrogram::cutInto(std::size_t clusters) const {
  if (clusters > leaves_ || (clusters == 0 && leaves_ > 0))
    throw Error(fmt::format("{} images cannot make {} clusters; choose 1 to {}", leaves_, clusters, leaves_));
  return afterMerges(leaves_ - clusters);
}

std::vector<int> Dendrogram::afterMerges(std::size_t count) const {
  std::vector<std::size_t> parent(leaves_ + count);  // its own: a root
  for (std::size_t i = 0; i < parent.size(); ++i) parent[i] = i;
  for (std::size_t k = 0; k < count; ++k) parent[merges_[k].left] = parent[merges_[k].right] = leaves_ + k;
  for (std::size_t i = parent.size(); i-- > 0;) parent[i] = parent[parent[i]];  // parents come after children
  std::vector<int> number(parent.size(), -1), clusters(leaves_);
  int next = 0;
  for (std::size_t leaf = 0; leaf < leaves_; ++leaf) {
    int& own = number[parent[leaf]];
    if (own < 0) own = next++;
    clusters[leaf] = own;
  }
  return clusters;
}

}  // namespace estancia
