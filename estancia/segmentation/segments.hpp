// Over-segmentation: convex segments of a depth image, separated at depth edges and concave creases.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "estancia/cloud/disjoint_sets.hpp"
#include "estancia/segmentation/inverse_depth.hpp"

namespace estancia {

/// Standard deviation of the difference of two depths of a Kinect, √2 σ [m at 1 m].
constexpr double differenceNoise = 0.002;
constexpr double minSegmentArea = 400;     ///< [square pixels]
constexpr std::size_t minBorderPairs = 5;  ///< pairs of adjacent points, for two segments to be neighbors

/// Segments of a depth image; label 0 is none.
struct Segmentation {
  std::vector<std::uint32_t> labels;  ///< one a pixel, indexed as InverseDepth
  std::vector<std::uint32_t> sizes;   ///< pixels of each label
  /// Adjacent segments a < b.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> touching;
};

/// The common border of two segments.
struct SegmentBorder {
  std::uint32_t a, b;                  ///< the segments, a < b
  std::size_t pairs = 0, creased = 0;  ///< pairs of adjacent pixels; of these at a crease
};

/// Borders from pairs of adjacent pixels, each encoded by pairOf().
std::vector<SegmentBorder> bordersOf(std::vector<std::uint64_t> pairs);
inline std::uint64_t pairOf(std::uint32_t a, std::uint32_t b, bool creased) {
  return std::uint64_t{std::min(a, b)} << 32 | std::uint64_t{std::max(a, b)} << 1 | std::uint64_t{creased};
}

/// Merges neighbors whose border is mostly no crease, then segments of less than `minSize` points with the
/// neighbor of the longest border. Returns the remaining borders in `borders`.
void mergeNeighbors(std::vector<SegmentBorder>& borders, DisjointSets& sets,
                    const std::vector<std::uint32_t>& sizes, double minSize);

/// Splits the pixels of `mask` at `creases` and at depth edges. Segments grow from seeds away from creases,
/// because a crease often has gaps; neighbors whose border is mostly no crease are merged again (convexity
/// decides which surfaces belong together: Stein et al., CVPR 2014), and small segments join their closest
/// neighbor.
Segmentation oversegment(const InverseDepth& grid, const Mask& mask, std::vector<std::uint8_t> creases);

/// Makes each set one segment, numbered in the order of appearance in the image.
void renumber(const Mask& mask, Segmentation& segments, DisjointSets& sets);

}  // namespace estancia
