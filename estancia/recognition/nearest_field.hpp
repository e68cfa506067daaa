// Nearest-neighbor field: the nearest point of a surface by lookup in a sparse voxel grid.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <opencv2/core/types.hpp>
#include <span>
#include <vector>

namespace estancia {

/// For every voxel near a surface the point that is nearest to the voxel's center. Only blocks of voxels near
/// points exist, in a hash table, so memory is proportional to the surface. Poses are tried by the hundred
/// thousand: a tree would take ten times as long.
class NearestField {
 public:
  static constexpr std::int32_t none = -1;

  NearestField() = default;
  /// Voxels of edge `cell` [m] up to `reach` [m] away from a point; both positive. Points whose voxel
  /// coordinates exceed the precision of a float are left out.
  NearestField(std::span<const cv::Point3f> points, double cell, double reach, int threads);

  /// Index of the point nearest to the center of the voxel of `place`; none when there is none within reach.
  std::int32_t at(const cv::Point3f& place) const {
    const std::array<float, 3> scaled{place.x * inverse_, place.y * inverse_, place.z * inverse_};
    std::array<std::int32_t, 3> block{};
    std::uint32_t cell = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      if (!(std::abs(scaled[k]) < maxCoordinate)) return none;
      const auto c = static_cast<std::int32_t>(std::floor(scaled[k]));
      block[k] = c >> bits;
      cell = (cell << bits) | (static_cast<std::uint32_t>(c) & mask);
    }
    const std::int32_t number = find(block);
    return number == none ? none : cells_[(static_cast<std::size_t>(number) << (3 * bits)) + cell];
  }

 private:
  static constexpr int bits = 3;  // 8 × 8 × 8 cells a block
  static constexpr std::uint32_t mask = (1U << bits) - 1;
  static constexpr float maxCoordinate = 1 << 29;  // voxels

  struct Slot {
    std::array<std::int32_t, 3> block{};
    std::int32_t number = none;
  };
  std::size_t slotOf(const std::array<std::int32_t, 3>& block) const {
    const std::uint32_t hash = static_cast<std::uint32_t>(block[0]) * 73856093U ^
                               static_cast<std::uint32_t>(block[1]) * 19349663U ^
                               static_cast<std::uint32_t>(block[2]) * 83492791U;
    return (hash ^ hash >> 15U) & (slots_.size() - 1);
  }
  std::int32_t find(const std::array<std::int32_t, 3>& block) const {
    if (slots_.empty()) return none;
    for (std::size_t s = slotOf(block);; s = (s + 1) & (slots_.size() - 1))
      if (slots_[s].number == none || slots_[s].block == block) return slots_[s].number;
  }

  float inverse_ = 1;
  std::vector<Slot> slots_;
  std::vector<std::int32_t> cells_;
};

}  // namespace estancia
