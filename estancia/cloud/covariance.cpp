// SPDX-License-Identifier: Apache-2.0
#include "estancia/cloud/covariance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "estancia/core/simd.hpp"

namespace estancia {
namespace {

constexpr std::size_t sumLanes = 16;
constexpr std::size_t sumCount = 10;  // 1, x, y, z, xx, xy, xz, yy, yz, zz

/// Adds the moments of the points within the radius, each lane for itself.
ESTANCIA_MULTIVERSION void add(const Neighbors::Block* all, const std::uint32_t* blocks, std::size_t count,
                               float px, float py, float pz, float squared, float* sums) {
  float lanes[sumCount][sumLanes];
  for (std::size_t s = 0; s < sumCount; ++s)
    for (std::size_t l = 0; l < sumLanes; ++l) lanes[s][l] = sums[s * sumLanes + l];
  for (std::size_t b = 0; b < count; ++b) {
    const Neighbors::Block& block = all[blocks[b]];
    for (std::size_t first = 0; first < Neighbors::blockSize; first += sumLanes)
#pragma omp simd
      for (std::size_t l = 0; l < sumLanes; ++l) {
        const float dx = block.x[first + l] - px, dy = block.y[first + l] - py, dz = block.z[first + l] - pz;
        const bool near = dx * dx + dy * dy + dz * dz <= squared;  // NaN is not
        const float x = near ? dx : 0, y = near ? dy : 0, z = near ? dz : 0;
        lanes[0][l] += near ? 1.F : 0.F;
        lanes[1][l] += x;
        lanes[2][l] += y;
        lanes[3][l] += z;
        lanes[4][l] += x * x;
        lanes[5][l] += x * y;
        lanes[6][l] += x * z;
        lanes[7][l] += y * y;
        lanes[8][l] += y * z;
        lanes[9][l] += z * z;
      }
  }
  for (std::size_t s = 0; s < sumCount; ++s)
    for (std::size_t l = 0; l < sumLanes; ++l) sums[s * sumLanes + l] = lanes[s][l];
}

}  // namespace

LocalCovariance localCovariance(const Neighbors& points, const cv::Point3f& place, float squared) {
  LocalCovariance local;
  std::array<double, sumCount> totals{};
  std::array<float, sumCount * sumLanes> sums{};
  const auto take = [&] {  // in double: long float sums lose digits
    for (std::size_t s = 0; s < sumCount; ++s)
      for (std::size_t l = 0; l < sumLanes; ++l) totals[s] += sums[s * sumLanes + l];
    sums.fill(0);
  };
  std::array<std::uint32_t, 128> blocks;
  std::size_t waiting = 0;
  points.eachBlock(place, squared, [&](std::uint32_t block) {
    blocks[waiting++] = block;
    if (waiting < blocks.size()) return;
    add(points.blocks().data(), blocks.data(), waiting, place.x, place.y, place.z, squared, sums.data());
    take();
    waiting = 0;
  });
  add(points.blocks().data(), blocks.data(), waiting, place.x, place.y, place.z, squared, sums.data());
  take();
  local.count = static_cast<std::size_t>(totals[0]);
  if (local.count == 0) return local;
  for (double& total : totals) total /= static_cast<double>(local.count);
  const auto& [one, x, y, z, xx, xy, xz, yy, yz, zz] = totals;
  local.offset = {x, y, z};
  local.covariance = {xx - x * x, xy - x * y, xz - x * z,  //
                      xy - x * y, yy - y * y, yz - y * z,  //
                      xz - x * z, yz - y * z, zz - z * z};
  return local;
}

PrincipalAxes principalAxes(const cv::Matx33d& c) {
  PrincipalAxes axes;
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  const double mean = (c(0, 0) + c(1, 1) + c(2, 2)) / 3;
  const double a = c(0, 0) - mean, b = c(1, 1) - mean, d = c(2, 2) - mean;
  const double off = c(0, 1) * c(0, 1) + c(0, 2) * c(0, 2) + c(1, 2) * c(1, 2);
  const double p = std::sqrt((a * a + b * b + d * d + 2 * off) / 6);
  if (!(p > 0)) {  // isotropic, or a single point: no direction is special
    axes.variances = {mean, mean, mean};
    axes.normal = {none, none, none};
    return axes;
  }
  const double det = a * (b * d - c(1, 2) * c(1, 2)) - c(0, 1) * (c(0, 1) * d - c(1, 2) * c(0, 2)) +
                     c(0, 2) * (c(0, 1) * c(1, 2) - b * c(0, 2));
  const double angle = std::acos(std::clamp(det / (2 * p * p * p), -1.0, 1.0)) / 3;
  const double largest = mean + 2 * p * std::cos(angle);
  const double smallest = mean + 2 * p * std::cos(angle + 2 * std::numbers::pi / 3);
  axes.variances = {std::max(smallest, 0.0), std::max(3 * mean - largest - smallest, 0.0), largest};
  // Two rows of C - smallest · I span the plane perpendicular to the normal; take the two that span it best.
  const cv::Vec3d rows[] = {{c(0, 0) - smallest, c(0, 1), c(0, 2)},
                            {c(0, 1), c(1, 1) - smallest, c(1, 2)},
                            {c(0, 2), c(1, 2), c(2, 2) - smallest}};
  double longest = 0;
  for (const auto& [i, j] : {std::pair{0, 1}, {0, 2}, {1, 2}}) {
    const cv::Vec3d across = rows[i].cross(rows[j]);
    if (const double length = across.dot(across); length > longest) {
      longest = length;
      axes.normal = across;
    }
  }
  constexpr double line = 1e-6;  // share of the largest variance: below, it is rounding of single precision
  const bool plane = axes.variances[1] > line * largest && longest > 0;
  axes.normal = plane ? axes.normal / std::sqrt(longest) : cv::Vec3d(none, none, none);
  return axes;
}

}  // namespace estancia
