// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>

#include "estancia/core/simd.hpp"
#include "estancia/recognition/descriptors.hpp"

namespace estancia {
namespace {

constexpr int bins = 11, length = 3 * bins;
constexpr std::size_t padded = 48;    // numbers of a histogram in memory: three vectors of 16
constexpr std::size_t together = 64;  // points that a thread takes at once
constexpr std::size_t minNeighbors = 5;

/// Oriented points, each in one half of a cache line.
struct alignas(32) Oriented {
  float x, y, z, nx, ny, nz, unused[2];
};

using Histogram = std::array<float, padded>;

/// Neighbors of a point by coordinate, for SIMD; bins of the three angles.
struct Pairs {
  std::vector<float> dx, dy, dz, nx, ny, nz;
  std::vector<std::int32_t> f1, f2, f3;
  void resize(std::size_t n) {
    if (dx.size() >= n) return;
    for (auto* list : {&dx, &dy, &dz, &nx, &ny, &nz}) list->resize(n);
    for (auto* list : {&f1, &f2, &f3}) list->resize(n);
  }
};

/// The bins of [−1, 1] or of the whole circle, 0 … 10; `bins` where a pair has no angles.
ESTANCIA_MULTIVERSION void binPairs(std::size_t n, float nx, float ny, float nz, const float* __restrict dx,
                                    const float* __restrict dy, const float* __restrict dz,
                                    const float* __restrict mx, const float* __restrict my,
                                    const float* __restrict mz, std::int32_t* __restrict f1,
                                    std::int32_t* __restrict f2, std::int32_t* __restrict f3) {
#pragma omp simd
  for (std::size_t i = 0; i < n; ++i) {
    const float length2 = dx[i] * dx[i] + dy[i] * dy[i] + dz[i] * dz[i];
    const float inverse = 1 / std::sqrt(length2);
    const float here = (nx * dx[i] + ny * dy[i] + nz * dz[i]) * inverse;
    const float other = (mx[i] * dx[i] + my[i] * dy[i] + mz[i] * dz[i]) * inverse;
    // The source is the one of the two whose normal is nearer to the line between them.
    const bool swap = std::abs(here) < std::abs(other);
    const float sx = swap ? mx[i] : nx, sy = swap ? my[i] : ny, sz = swap ? mz[i] : nz;
    const float tx = swap ? nx : mx[i], ty = swap ? ny : my[i], tz = swap ? nz : mz[i];
    const float sign = swap ? -1.F : 1.F;
    const float ex = sign * dx[i], ey = sign * dy[i], ez = sign * dz[i];
    // The Darboux frame u = s, v = d × u, w = u × v.
    float vx = ey * sz - ez * sy, vy = ez * sx - ex * sz, vz = ex * sy - ey * sx;
    const float v2 = vx * vx + vy * vy + vz * vz;
    const float per = 1 / std::sqrt(v2);
    vx *= per, vy *= per, vz *= per;
    const float wx = sy * vz - sz * vy, wy = sz * vx - sx * vz, wz = sx * vy - sy * vx;
    const float phi = swap ? -other : here;
    const float alpha = vx * tx + vy * ty + vz * tz;
    const float up = wx * tx + wy * ty + wz * tz, along = sx * tx + sy * ty + sz * tz;
    const float side = std::abs(up);
    // The angle's bin, by the borders (2j − 1) π / 11 on either side of 0 that it has passed: no arc tangent.
    const std::int32_t passed =
        (side * 0.959492974F >= along * 0.281732557F) + (side * 0.654860734F >= along * 0.755749574F) +
        (side * 0.142314838F >= along * 0.989821442F) + (side * -0.415415013F >= along * 0.909631995F) +
        (side * -0.841253533F >= along * 0.540640817F);
    const bool none = !(length2 > 0) || !(v2 > 0);  // and then alpha is no number
    const auto a = static_cast<std::int32_t>(none ? 0.F : (alpha + 1) * 5.5F);
    const auto p = static_cast<std::int32_t>(none ? 0.F : (phi + 1) * 5.5F);
    f1[i] = none ? bins : (up < 0 ? 5 - passed : 5 + passed);
    f2[i] = none ? bins : (a < 0 ? 0 : (a < bins ? a : bins - 1));
    f3[i] = none ? bins : (p < 0 ? 0 : (p < bins ? p : bins - 1));
  }
}

/// sum += weight × histogram, for all of them.
ESTANCIA_MULTIVERSION void add(const Histogram& histogram, float weight, float* __restrict sum) {
#pragma omp simd
  for (std::size_t b = 0; b < padded; ++b) sum[b] += weight * histogram[b];
}

/// The simplified histogram of one point: angles between it and each of its neighbors, in per cent.
Histogram simplified(const std::vector<Oriented>& points, std::uint32_t p, std::span<const Neighbor> near,
                     Pairs& pairs) {
  const Oriented& here = points[p];
  pairs.resize(near.size());
  std::size_t n = 0;
  for (const Neighbor& neighbor : near) {
    if (neighbor.index == p) continue;
    const Oriented& other = points[neighbor.index];
    pairs.dx[n] = other.x - here.x, pairs.dy[n] = other.y - here.y, pairs.dz[n] = other.z - here.z;
    pairs.nx[n] = other.nx, pairs.ny[n] = other.ny, pairs.nz[n] = other.nz;
    ++n;
  }
  binPairs(n, here.nx, here.ny, here.nz, pairs.dx.data(), pairs.dy.data(), pairs.dz.data(), pairs.nx.data(),
           pairs.ny.data(), pairs.nz.data(), pairs.f1.data(), pairs.f2.data(), pairs.f3.data());
  // Two sets of counters, because a counter that was just written is slow to read.
  std::array<std::uint32_t, 2 * 3 * (bins + 1)> counts{};
  for (std::size_t i = 0; i < n; ++i) {
    std::uint32_t* set = counts.data() + i % 2 * 3 * (bins + 1);
    ++set[pairs.f1[i]];
    ++set[bins + 1 + pairs.f2[i]];
    ++set[2 * (bins + 1) + pairs.f3[i]];
  }
  Histogram histogram{};
  if (near.size() < 2) return histogram;
  const float share = 100.F / static_cast<float>(near.size() - 1);
  for (std::size_t f = 0; f < 3; ++f)
    for (std::size_t b = 0; b < bins; ++b)
      histogram[f * bins + b] =
          share * static_cast<float>(counts[f * (bins + 1) + b] + counts[(3 + f) * (bins + 1) + b]);
  return histogram;
}

/// The neighbors' histograms, weighted by proximity; each third sums to 100.
void weigh(std::span<const Neighbor> near, const std::vector<std::uint32_t>& row,
           const std::vector<Histogram>& histograms, float* fpfh) {
  alignas(64) float sum[padded] = {};
  for (const Neighbor& n : near)
    if (n.squared > 0) add(histograms[row[n.index]], 1 / n.squared, sum);
  for (int f = 0; f < 3; ++f) {
    float total = 0;
    for (int b = 0; b < bins; ++b) total += sum[f * bins + b];
    for (int b = 0; b < bins; ++b) fpfh[f * bins + b] = total > 0 ? sum[f * bins + b] * (100 / total) : 0;
  }
}

}  // namespace

void describeFpfh(const Surface& surface, std::span<const std::uint32_t> keypoints, double radius,
                  int threads, std::vector<float>& values) {
  const Neighbors& neighbors = surface.neighbors();
  const auto reach = static_cast<float>(radius);
  const std::size_t size = surface.size();
  const char* const stopped = "stopped while a surface was described";

  // Histograms are needed of every point near a keypoint. Bytes that any thread sets to 1.
  std::vector<std::uint8_t> needed(size, 0);
  std::vector<std::atomic<std::uint8_t>> marks(keypoints.size() < size ? size : 0);
  if (marks.empty())
    std::fill(needed.begin(), needed.end(), 1);
  else
    inChunks(keypoints.size(), together, threads, stopped, [&](std::size_t first, std::size_t last) {
      std::vector<Neighbor> buffer;
      for (std::size_t i = first; i < last; ++i)
        for (const Neighbor& n : neighbors.within(surface.points()[keypoints[i]], reach, buffer))
          marks[n.index].store(1, std::memory_order_relaxed);
    });
  for (std::size_t i = 0; i < marks.size(); ++i) needed[i] = marks[i].load(std::memory_order_relaxed);

  // In the order of the tree: neighbors in space are neighbors in memory.
  std::vector<std::uint32_t> row(size, 0), some;
  for (const std::uint32_t i : neighbors.order())
    if (needed[i]) {
      row[i] = static_cast<std::uint32_t>(some.size());
      some.push_back(i);
    }
  std::vector<Oriented> points(size);
  for (std::size_t i = 0; i < size; ++i) {
    const cv::Point3f &p = surface.points()[i], &n = surface.normals()[i];
    points[i] = {p.x, p.y, p.z, n.x, n.y, n.z, {0, 0}};
  }
  std::vector<Histogram> histograms(some.size());
  inChunks(some.size(), together, threads, stopped, [&](std::size_t first, std::size_t last) {
    std::vector<Neighbor> buffer;
    Pairs pairs;
    for (std::size_t i = first; i < last; ++i)
      histograms[i] =
          simplified(points, some[i], neighbors.within(surface.points()[some[i]], reach, buffer), pairs);
  });

  values.resize(keypoints.size() * length);
  inChunks(keypoints.size(), together, threads, stopped, [&](std::size_t first, std::size_t last) {
    std::vector<Neighbor> buffer;
    for (std::size_t i = first; i < last; ++i) {
      const auto near = neighbors.within(surface.points()[keypoints[i]], reach, buffer);
      float* const fpfh = values.data() + i * length;
      if (near.size() < minNeighbors)
        std::fill_n(fpfh, length, std::numeric_limits<float>::quiet_NaN());
      else
        weigh(near, row, histograms, fpfh);
    }
  });
}

}  // namespace estancia
