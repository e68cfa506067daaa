// SPDX-License-Identifier: Apache-2.0
#include "estancia/cloud/voxel_grid.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "estancia/cloud/bounds.hpp"
#include "estancia/core/fail.hpp"

namespace estancia {
namespace {

constexpr std::uint32_t noVoxel = std::numeric_limits<std::uint32_t>::max();

/// Hash table of voxels; reused for another leaf, it allocates no new memory.
class VoxelTable {
 public:
  explicit VoxelTable(const std::vector<cv::Point3f>& points, cv::Point3f origin = {})
      : points_(points), origin_(std::move(origin)) {
    if (points.size() >= noVoxel / 4)
      fail(ErrorCode::tooLarge, "a cloud of {} points is too large for a voxel grid; split it",
           points.size());
    slots_.resize(std::bit_ceil(2 * points.size() + 2));
  }

  /// Calls use(point, voxel) for each finite point; voxels are numbered as they appear. Returns their number.
  template <class Use>
  std::size_t number(double leaf, const Use& use) {
    if (!(leaf > 0) || !std::isfinite(leaf))
      fail(ErrorCode::invalidOption, "leaf is {} m; give an edge above 0", leaf);
    const auto perMeter = static_cast<float>(1 / leaf);
    std::ranges::fill(slots_, noVoxel);
    keys_.clear();
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (!isFinite(points_[i])) continue;
      const cv::Point3f p = points_[i] - origin_;
      use(i, find({cell(p.x, perMeter), cell(p.y, perMeter), cell(p.z, perMeter)}));
    }
    return keys_.size();
  }

 private:
  /// Floats as coordinates are: integers would overflow for small voxels.
  using Key = std::array<float, 3>;

  static float cell(float value, float perMeter) {
    const float cell = std::floor(value * perMeter) + 0.F;  // 0 is never -0
    return std::isfinite(cell) ? cell : value;              // such a value has a voxel of its own
  }

  std::uint32_t find(const Key& key) {
    std::uint64_t hash = 0;
    for (const float value : key)
      hash = (std::rotl(hash, 25) ^ std::bit_cast<std::uint32_t>(value)) * 0x9E3779B97F4A7C15U;
    const std::size_t last = slots_.size() - 1;
    for (std::size_t slot = (hash >> 32U ^ hash >> 7U) & last;; slot = (slot + 1) & last) {
      std::uint32_t& voxel = slots_[slot];
      if (voxel == noVoxel) {
        voxel = static_cast<std::uint32_t>(keys_.size());
        keys_.push_back(key);
        return voxel;
      }
      if (keys_[voxel] == key) return voxel;
    }
  }

  const std::vector<cv::Point3f>& points_;
  cv::Point3f origin_;
  std::vector<std::uint32_t> slots_;
  std::vector<Key> keys_;  ///< keys of the voxels
};

/// Sums over a voxel.
struct Sums {
  cv::Point3d points, normals;
  cv::Vec<std::uint64_t, 3> colors;
  std::uint32_t count = 0;
};

}  // namespace

PointCloud voxelGrid(const PointCloud& cloud, double leaf, std::vector<std::uint32_t>* counts) {
  validate(cloud);
  std::vector<Sums> voxels;
  VoxelTable(cloud.points).number(leaf, [&](std::size_t i, std::uint32_t voxel) {
    if (voxel == voxels.size()) voxels.emplace_back();
    Sums& sums = voxels[voxel];
    ++sums.count;
    sums.points += cv::Point3d(cloud.points[i]);
    if (!cloud.normals.empty() && isFinite(cloud.normals[i])) sums.normals += cv::Point3d(cloud.normals[i]);
    for (int c = 0; c < 3 && !cloud.colors.empty(); ++c) sums.colors[c] += cloud.colors[i][c];
  });
  PointCloud result;
  result.width = voxels.size();
  result.height = 1;
  result.points.reserve(voxels.size());
  if (counts) counts->clear();
  for (const Sums& sums : voxels) {
    if (counts) counts->push_back(sums.count);
    result.points.emplace_back(sums.points / static_cast<double>(sums.count));
    if (!cloud.normals.empty()) result.normals.push_back(asNormal(sums.normals));
    if (cloud.colors.empty()) continue;
    const auto mean = [&](int c) {
      return static_cast<uchar>((sums.colors[c] + sums.count / 2) / sums.count);
    };
    result.colors.emplace_back(mean(0), mean(1), mean(2));
  }
  return result;
}

std::vector<std::uint32_t> onePerVoxel(const std::vector<cv::Point3f>& points, double leaf) {
  struct Voxel {
    cv::Point3d sum;
    double count = 0, squared = std::numeric_limits<double>::infinity();
    std::uint32_t nearest = 0;
  };
  std::vector<Voxel> voxels;
  std::vector<std::uint32_t> voxelOf(points.size(), noVoxel);
  VoxelTable(points, boundsOf(points).low).number(leaf, [&](std::size_t i, std::uint32_t voxel) {
    if (voxel == voxels.size()) voxels.emplace_back();
    voxels[voxel].sum += cv::Point3d(points[i]);
    ++voxels[voxel].count;
    voxelOf[i] = voxel;
  });
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (voxelOf[i] == noVoxel) continue;
    Voxel& voxel = voxels[voxelOf[i]];
    const cv::Point3d d = cv::Point3d(points[i]) - voxel.sum / voxel.count;
    if (const double squared = d.dot(d); squared < voxel.squared) voxel.squared = squared, voxel.nearest = i;
  }
  std::vector<std::uint32_t> chosen;
  for (const Voxel& voxel : voxels) chosen.push_back(voxel.nearest);
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

Leaf findLeaf(const PointCloud& cloud, std::size_t points) {
  const Bounds<float> box = boundsOf(cloud.points);
  if (box.empty())
    throw Error(ErrorCode::invalidInput, "no point of the cloud is finite, so it has no voxels");
  if (points == 0)
    throw Error(ErrorCode::invalidOption, "the voxel grid should leave 0 points; give 1 or more");
  const cv::Point3d size = cv::Point3d(box.high) - cv::Point3d(box.low);
  const double extent = std::max({size.x, size.y, size.z});
  VoxelTable table(cloud.points);
  const auto countOf = [&table](double leaf) {
    return table.number(leaf, [](std::size_t, std::uint32_t) {});
  };
  if (extent == 0) return {1, countOf(1)};

  Leaf best;
  const auto distance = [points](std::size_t count) {
    return count > points ? count - points : points - count;
  };
  // Surfaces occupy about (extent / leaf)² voxels, so every count gives a better leaf (secant step). Every
  // third step bisects instead, until leaves hardly differ.
  double small = extent * 0x1p-24, large = 2 * extent,
         guess = extent / std::sqrt(static_cast<double>(points));
  for (int step = 0; step < 100 && large / small > 1 + 1e-6; ++step) {
    const bool inside = guess > small && guess < large;
    const double leaf = inside && step % 3 != 2 ? guess : std::sqrt(small * large);
    const std::size_t count = countOf(leaf);
    if (best.points == 0 || distance(count) < distance(best.points)) best = {leaf, count};
    if (count == points) break;
    (count > points ? small : large) = leaf;
    guess = leaf * std::sqrt(static_cast<double>(count) / static_cast<double>(points));
  }
  return best;
}

}  // namespace estancia
