// SPDX-License-Identifier: Apache-2.0
#include "estancia/segmentation/inverse_depth.hpp"

#include <array>

#include "estancia/core/cores.hpp"
#include "estancia/core/parallel.hpp"
#include "estancia/core/point_cloud.hpp"
#include "estancia/core/simd.hpp"

namespace estancia {
namespace {

constexpr float minDepth = 1e-3F, maxDepth = 1e3F;  // [m]
constexpr double focalLength = 525;                 // for which lengths in pixels are given
constexpr double minScale = 0.25, maxScale = 4;
constexpr std::array radii{4, 6, 8};   // radii of bends [pixels]
constexpr float sameSurface = 0.036F;  // share of 1/z, for smoothing
constexpr float nearSurface = 0.06F;   // share of 1/z, for bends
constexpr float maxBend = 0.03F;       // depth of a bend [m]: beyond, it is an edge

ESTANCIA_MULTIVERSION
void invertRow(const float* depth, int width, float* out) {
  for (int u = 0; u < width; ++u) {
    const float z = depth[u];
    out[u] = z >= minDepth && z <= maxDepth ? 1 / z : 0;
  }
}

/// Adds a pair of opposite neighbors where both are near the pixel between them.
ESTANCIA_MULTIVERSION
void addPair(const float* middle, const float* a, const float* b, int width, float* sum, float* count) {
  for (int u = 0; u < width; ++u) {
    const float c = middle[u], limit = sameSurface * c;
    const float farther = std::max(std::abs(a[u] - c), std::abs(b[u] - c));
    sum[u] += farther < limit ? a[u] + b[u] : 0.F;
    count[u] += farther < limit ? 2.F : 0.F;
  }
}

ESTANCIA_MULTIVERSION
void divideRow(const float* sum, const float* count, int width, float* out) {
  for (int u = 0; u < width; ++u) out[u] = sum[u] / count[u];
}

/// Adds the bend of the surface between two opposite neighbors, scaled to the mean radius.
ESTANCIA_MULTIVERSION
void addBend(const float* middle, const float* a, const float* b, float perPixel, int width, float* sum,
             float* count) {
  for (int u = 0; u < width; ++u) {
    const float c = middle[u], limit = nearSurface * c;
    const float bend = 0.5F * (a[u] + b[u]) - c;
    const float farther = std::max(std::abs(a[u] - c), std::abs(b[u] - c));
    const bool surface = (farther < limit) & (std::abs(bend) < maxBend * c * c);
    sum[u] += surface ? bend * perPixel : 0.F;
    count[u] += surface ? 1.F : 0.F;
  }
}

ESTANCIA_MULTIVERSION
void keepDeepest(const float* sum, const float* count, int width, float* deepest) {
  for (int u = 0; u < width; ++u) deepest[u] = std::max(deepest[u], sum[u] / std::max(count[u], 1.F));
}

ESTANCIA_MULTIVERSION
void markDeep(const float* deepest, const float* middle, float depth, int width, const std::uint8_t* mask,
              std::uint8_t* out) {
  for (int u = 0; u < width; ++u)
    out[u] = static_cast<std::uint8_t>(mask[u] & (deepest[u] > depth * std::max(middle[u] * middle[u], 1.F)));
}

/// Interpolates pixels without depth between two neighbors in their row or column of one surface.
void bridgeGaps(InverseDepth& grid) {
  std::vector<float> values;
  for (int v = 0; v < grid.camera.height; ++v)
    for (int u = 0; u < grid.camera.width; ++u) {
      const std::size_t i = grid.at(u, v);
      if (grid.raw[i] > 0) continue;
      const auto down = static_cast<std::size_t>(grid.stride);
      for (const std::size_t step : {std::size_t{1}, down}) {
        if (!isContinuous(grid.raw[i - step], grid.raw[i + step])) continue;  // nor are two without depth
        grid.bridged.push_back(static_cast<std::uint32_t>(i));
        values.push_back((grid.raw[i - step] + grid.raw[i + step]) / 2);
        break;
      }
    }
  for (std::size_t k = 0; k < values.size(); ++k) grid.raw[grid.bridged[k]] = values[k];
}

void smoothRow(const InverseDepth& grid, int v, std::vector<float>& count, float* out) {
  const int width = grid.camera.width;
  const float* middle = &grid.raw[grid.at(0, v)];
  std::copy_n(middle, width, out);
  std::ranges::fill(count, 1.F);
  for (int dy = 0; dy <= 2; ++dy)
    for (int dx = dy == 0 ? 1 : -2; dx <= 2; ++dx) {
      const std::ptrdiff_t away = dy * grid.stride + dx;
      addPair(middle, middle + away, middle - away, width, out, count.data());
    }
  divideRow(out, count.data(), width, out);
}

}  // namespace

void inBands(int rows, int threads, const std::function<void(int, int)>& work) {
  const int bands = std::clamp(threads > 0 ? threads : usableCores(), 1, std::max(1, rows / 16));
  inParallel(static_cast<std::size_t>(bands), static_cast<std::size_t>(bands), [&](std::size_t i) {
    const auto band = static_cast<int>(i);
    work(rows * band / bands, rows * (band + 1) / bands);
  });
}

InverseDepth inverseDepth(const cv::Mat& depth, const CameraIntrinsics& camera, int threads) {
  requireDepth(depth, camera);
  InverseDepth grid;
  grid.camera = camera.scaledTo(depth.cols, depth.rows);
  grid.scale = std::clamp(grid.camera.fx / focalLength, minScale, maxScale);
  grid.margin = grid.pixels(radii.back());
  grid.stride = depth.cols + 2 * grid.margin;
  grid.raw.resize(static_cast<std::size_t>(grid.stride) *
                  static_cast<std::size_t>(depth.rows + 2 * grid.margin));
  grid.smooth.resize(grid.raw.size());
  for (int u = 0; u < depth.cols; ++u) grid.slopeX.push_back(static_cast<float>(grid.camera.slopeX(u)));
  for (int v = 0; v < depth.rows; ++v) grid.slopeY.push_back(static_cast<float>(grid.camera.slopeY(v)));
  inBands(depth.rows, threads, [&](int first, int last) {
    for (int v = first; v < last; ++v) invertRow(depth.ptr<float>(v), depth.cols, &grid.raw[grid.at(0, v)]);
  });
  bridgeGaps(grid);
  inBands(depth.rows, threads, [&](int first, int last) {
    std::vector<float> count(static_cast<std::size_t>(depth.cols));
    for (int v = first; v < last; ++v) smoothRow(grid, v, count, &grid.smooth[grid.at(0, v)]);
  });
  return grid;
}

Mask::Mask(const InverseDepth& grid, std::vector<std::uint8_t> pixels) : in(std::move(pixels)) {
  rows.reserve(static_cast<std::size_t>(grid.camera.height));
  for (int v = 0; v < grid.camera.height; ++v) {
    const auto begin = in.begin() + static_cast<std::ptrdiff_t>(grid.at(0, v)),
               end = begin + grid.camera.width;
    const auto first = std::find(begin, end, 1);
    auto last = end;
    while (last != first && *(last - 1) == 0) --last;
    rows.push_back(
        {static_cast<std::size_t>(first - in.begin()), static_cast<std::size_t>(last - in.begin())});
  }
}

std::vector<std::uint8_t> concaveCreases(const InverseDepth& grid, const Mask& mask, double depth,
                                         int threads) {
  constexpr double meanRadius = 6;
  constexpr int directions[][2] = {{1, 0}, {0, 1}, {1, 1}, {-1, 1}};
  std::vector<std::uint8_t> creases(grid.size());
  inBands(grid.camera.height, threads, [&](int firstRow, int lastRow) {
    std::vector<float> sum, count, deepest;
    for (int v = firstRow; v < lastRow; ++v) {
      const auto [first, last] = mask.rows[static_cast<std::size_t>(v)];
      if (first == last) continue;
      const float* middle = &grid.smooth[first];
      deepest.assign(last - first, 0);
      for (const auto& [dx, dy] : directions) {
        sum.assign(last - first, 0);
        count.assign(last - first, 0);
        for (const int radius : radii) {
          const int steps = grid.pixels(dx != 0 && dy != 0 ? radius / std::sqrt(2.) : radius);
          const std::ptrdiff_t away = steps * (dy * grid.stride + dx);
          addBend(middle, middle + away, middle - away, static_cast<float>(meanRadius / radius),
                  static_cast<int>(last - first), sum.data(), count.data());
        }
        keepDeepest(sum.data(), count.data(), static_cast<int>(last - first), deepest.data());
      }
      markDeep(deepest.data(), middle, static_cast<float>(depth), static_cast<int>(last - first),
               &mask.in[first], &creases[first]);
    }
  });
  return creases;
}

}  // namespace estancia
