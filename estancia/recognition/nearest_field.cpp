// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/nearest_field.hpp"

#include <algorithm>
#include <bit>
#include <utility>

#include "estancia/cloud/neighbors.hpp"

namespace estancia {
namespace {

using Triple = std::array<std::int32_t, 3>;
constexpr std::size_t side = 8, blockCells = side * side * side;  // edge of a block

/// A block within the reach of a point.
using BlockPoint = std::pair<Triple, std::uint32_t>;

/// Fills in a block: for each voxel the nearest of its points.
void fill(std::span<const BlockPoint> points, const std::vector<cv::Point3f>& scaled, float far,
          std::vector<float>& best, std::int32_t* cells) {
  std::ranges::fill(best, far * far);
  const Triple& block = points.front().first;
  for (const auto& [unused, i] : points) {
    // Coordinates in the block, whose voxels have their centers at 0, 1, …
    const float px = scaled[i].x - static_cast<float>(block[0] * 8) - 0.5F;
    const float py = scaled[i].y - static_cast<float>(block[1] * 8) - 0.5F;
    const float pz = scaled[i].z - static_cast<float>(block[2] * 8) - 0.5F;
    for (std::size_t x = 0; x < side; ++x) {
      const float dx = static_cast<float>(x) - px;
      if (std::abs(dx) > far) continue;
      for (std::size_t y = 0; y < side; ++y) {
        const float dy = static_cast<float>(y) - py, across = dx * dx + dy * dy;
        if (across > far * far) continue;
        for (std::size_t z = 0; z < side; ++z) {
          const std::size_t c = (x * side + y) * side + z;
          const float dz = static_cast<float>(z) - pz, squared = across + dz * dz;
          if (squared < best[c]) best[c] = squared, cells[c] = static_cast<std::int32_t>(i);
        }
      }
    }
  }
}

}  // namespace

NearestField::NearestField(std::span<const cv::Point3f> points, double cell, double reach, int threads)
    : inverse_(static_cast<float>(1 / cell)) {
  const auto far = static_cast<float>(reach / cell);
  std::vector<BlockPoint> pairs;
  std::vector<cv::Point3f> scaled(points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const cv::Point3f p = scaled[i] = points[i] * inverse_;
    if (!(std::abs(p.x) + far < maxCoordinate && std::abs(p.y) + far < maxCoordinate &&
          std::abs(p.z) + far < maxCoordinate))
      continue;
    const auto block = [](float v) { return static_cast<std::int32_t>(std::floor(v)) >> bits; };
    for (std::int32_t x = block(p.x - far); x <= block(p.x + far); ++x)
      for (std::int32_t y = block(p.y - far); y <= block(p.y + far); ++y)
        for (std::int32_t z = block(p.z - far); z <= block(p.z + far); ++z) pairs.push_back({{x, y, z}, i});
  }
  std::sort(pairs.begin(), pairs.end());
  std::vector<std::size_t> starts;
  for (std::size_t i = 0; i < pairs.size(); ++i)
    if (i == 0 || pairs[i].first != pairs[i - 1].first) starts.push_back(i);
  slots_.resize(std::bit_ceil(2 * starts.size() + 2));
  for (std::size_t b = 0; b < starts.size(); ++b) {
    std::size_t s = slotOf(pairs[starts[b]].first);
    while (slots_[s].number != none) s = (s + 1) & (slots_.size() - 1);
    slots_[s] = {pairs[starts[b]].first, static_cast<std::int32_t>(b)};
  }
  static_assert(side == 1U << bits);
  cells_.assign(starts.size() * blockCells, none);
  inChunks(starts.size(), 32, threads, "stopped while a nearest-neighbor field was computed",
           [&](std::size_t first, std::size_t last) {
             std::vector<float> best(blockCells);
             for (std::size_t b = first; b < last; ++b) {
               const std::size_t end = b + 1 < starts.size() ? starts[b + 1] : pairs.size();
               fill({&pairs[starts[b]], end - starts[b]}, scaled, far, best, cells_.data() + b * blockCells);
             }
           });
}

}  // namespace estancia
