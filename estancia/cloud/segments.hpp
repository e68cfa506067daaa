// A depth image without its planes, cut where convex pieces meet.
#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "estancia/cloud/inverse_depth.hpp"

namespace estancia {

/// Numbers that become one set after another (union-find, halving paths); a set goes by its lowest number.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }
  std::uint32_t add() {
    parent_.push_back(static_cast<std::uint32_t>(parent_.size()));
    return parent_.back();
  }
  std::size_t size() const { return parent_.size(); }
  std::uint32_t find(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = find(a);
    b = find(b);
    if (a < b) std::swap(a, b);
    parent_[a] = b;
  }

 private:
  std::vector<std::uint32_t> parent_;
};

constexpr double kMinSegmentArea = 400;     ///< [square pixels]
constexpr std::size_t kMinBorderPairs = 5;  ///< pairs of points that make two pieces neighbors

/// Pieces of a depth image; number 0 is none.
struct Segmentation {
  std::vector<std::uint32_t> labels;  ///< a number a pixel, indexed as InverseDepth
  std::vector<std::uint32_t> sizes;   ///< pixels of each number
  /// A < b: surfaces that go over into each other.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> touching;
};

/// Where two pieces go over into each other.
struct SegmentBorder {
  std::uint32_t a, b;                  ///< the pieces, a < b
  std::size_t pairs = 0, creased = 0;  ///< of neighbors on either side; of these at a crease
};

/// Borders out of single pairs of neighbors, each put together by pairOf().
std::vector<SegmentBorder> bordersOf(std::vector<std::uint64_t> pairs);
inline std::uint64_t pairOf(std::uint32_t a, std::uint32_t b, bool creased) {
  return std::uint64_t{std::min(a, b)} << 32 | std::uint64_t{std::max(a, b)} << 1 | std::uint64_t{creased};
}

/// Joins neighbors whose border mostly is no crease, then those of less than `least` points with the
/// neighbor of the longest border. Leaves the borders that are left.
void mergeNeighbors(std::vector<SegmentBorder>& borders, DisjointSets& sets,
                    const std::vector<std::uint32_t>& sizes, double least);

/// Cuts what `mask` marks at `creases` and at edges in depth. Pieces grow from where no crease is near, as a
/// crease often has gaps; neighbors whose border mostly is no crease are one again (convexity decides which
/// surfaces belong together: Stein et al., CVPR 2014), and what is small goes to its closest neighbor.
Segmentation oversegment(const InverseDepth& grid, const Mask& mask, std::vector<std::uint8_t> creases);

/// Sets become pieces, numbered as they appear in the image.
void renumber(const Mask& mask, Segmentation& pieces, DisjointSets& sets);

}  // namespace estancia
