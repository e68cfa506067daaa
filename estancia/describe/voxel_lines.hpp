// Voxel lines: the share of a straight line that lies in a voxelized surface (for ESF).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core/types.hpp>
#include <span>
#include <vector>

namespace estancia::describe {

/// 64³ voxels, one bit each: 32 KB, which fit the L1 cache.
class VoxelGrid {
 public:
  static constexpr int gridSide = 64;

  /// Marks the voxel of every point, and its 26 neighbors. Coordinates lie within ±32.
  explicit VoxelGrid(std::span<const cv::Point3f> points);

  /// The number of a point's voxel.
  std::int32_t voxelOf(std::size_t point) const { return voxels_[point]; }

  /// From one voxel to another, the last one excluded (PCL's lci()).
  struct Line {
    std::int32_t from, to;
    /// Voxels that it passes, at least 1, and how many of them are marked.
    std::int32_t voxels, marked;
  };
  /// Fills in `voxels` and `marked`.
  void trace(std::span<Line> lines) const;

 private:
  std::vector<std::int32_t> voxels_;  // voxels of the points: (x · 64 + y) · 64 + z
  std::vector<std::uint32_t> bits_;   // in that order
};

}  // namespace estancia::describe
