// Nearest neighbors: a k-d tree over the points of a cloud.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <opencv2/core/types.hpp>
#include <span>
#include <vector>

#include "estancia/core/parallel.hpp"

namespace estancia {

struct Neighbor {
  std::uint32_t index;  ///< in the cloud
  float squared;        ///< squared distance [m²]
};

/// Calls work(first, last) for chunks of the numbers below `count`, `together` in each, on `threads` threads
/// (0: one a usable core). Throws Interrupted with the sentence `stopped`.
template <class Work>
void inChunks(std::size_t count, std::size_t together, int threads, const char* stopped, const Work& work) {
  inParallel((count + together - 1) / together, threads, Progress::none(), stopped,
             [&](std::size_t chunk) { work(chunk * together, std::min(count, (chunk + 1) * together)); });
}

/// A k-d tree (Bentley 1975) over the finite points of a cloud, whose leaves are blocks of points that are
/// compared with SIMD. Exact, for any density and extent. Immutable and thread-safe; each thread passes its
/// own buffer, which grows as needed and is reused.
class Neighbors {
 public:
  static constexpr std::size_t blockSize = 32;

  /// blockSize points by coordinate; x is NaN behind the last point of the last block.
  struct alignas(64) Block {
    float x[blockSize], y[blockSize], z[blockSize];
    std::uint32_t index[blockSize];
  };

  /// A box around all points below it. Nodes lie in depth-first order: the first child of an inner node is
  /// the next one, the second is where the first one's `skip` leads.
  struct Node {
    float low[3], high[3];
    std::uint32_t skip;         ///< the node after all below this one
    std::uint32_t first, last;  ///< its blocks: first ≤ b < last; a leaf has one
  };

  /// Copies what it needs of `points`, on `threads` threads (0: one a usable core); the result does not
  /// depend on them. Throws Error (tooLarge) on 2³² points or more.
  explicit Neighbors(std::span<const cv::Point3f> points, int threads = 1);

  /// How many points are finite.
  std::size_t size() const { return order_.size(); }

  /// Their indices in the order of the tree: neighbors in this list are neighbors in space, and in the cache.
  std::span<const std::uint32_t> order() const { return order_; }

  /// Where the i-th point of order() is.
  cv::Point3f place(std::size_t i) const {
    const Block& block = blocks_[i / blockSize];
    const std::size_t j = i % blockSize;
    return {block.x[j], block.y[j], block.z[j]};
  }

  /// The points at most `radius` [m] away, including one at `place` itself, in a fixed but arbitrary order.
  /// Valid until `buffer` is used again. Empty when `place` is not finite.
  std::span<const Neighbor> within(const cv::Point3f& place, float radius,
                                   std::vector<Neighbor>& buffer) const;

  /// The `count` nearest points (fewer when there are no more) within `maxDistance` [m], nearest first,
  /// including one at `place` itself. Which of several points at the same distance are returned is fixed but
  /// arbitrary.
  std::span<const Neighbor> nearest(const cv::Point3f& place, std::size_t count,
                                    std::vector<Neighbor>& buffer,
                                    float maxDistance = std::numeric_limits<float>::infinity()) const;

  /// Calls use(i, within(point i)) for every finite point i of the cloud, on `threads` threads (0: one a
  /// usable core), in no particular order.
  template <class Use>
  void eachWithin(float radius, int threads, const Use& use) const {
    inChunks(order_.size(), 16 * blockSize, threads, "stopped while points were searched",
             [&](std::size_t first, std::size_t last) {
               std::vector<Neighbor> buffer;
               for (std::size_t i = first; i < last; ++i) use(order_[i], within(place(i), radius, buffer));
             });
  }

  /// Calls use(block) with the number of each block that may hold points at most √squared [m] from `place`.
  template <class Use>
  void eachBlock(const cv::Point3f& place, float squared, const Use& use) const {
    for (std::size_t i = 0; i < nodes_.size();) {
      const Node& node = nodes_[i];
      if (!(squaredTo(node, place) <= squared)) {  // NaN is not
        i = node.skip;
        continue;
      }
      if (node.last == node.first + 1) use(node.first);
      ++i;
    }
  }
  std::span<const Node> nodes() const { return nodes_; }
  std::span<const Block> blocks() const { return blocks_; }

 private:
  struct Item;

  /// Squared distance from a place to a box. Rounded as distances to points are, so never above any of those.
  static float squaredTo(const Node& node, const cv::Point3f& p) {
    const float dx = std::max({node.low[0] - p.x, p.x - node.high[0], 0.F});
    const float dy = std::max({node.low[1] - p.y, p.y - node.high[1], 0.F});
    const float dz = std::max({node.low[2] - p.z, p.z - node.high[2], 0.F});
    return dx * dx + dy * dy + dz * dz;
  }
  void build(std::span<Item> items, std::size_t node, std::size_t block, std::size_t threads);

  std::vector<Node> nodes_;
  std::vector<Block> blocks_;
  std::vector<std::uint32_t> order_;  ///< the indices of all blocks
};

}  // namespace estancia
