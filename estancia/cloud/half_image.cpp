#include "estancia/cloud/half_image.hpp"

#include <algorithm>
#include <cmath>

#include "estancia/core/simd.hpp"

namespace estancia {
namespace {

/// Adds the slope of 1/z between two opposite neighbors where both are on the same surface.
ESTANCIA_MULTIVERSION
void addSlope(const float* middle, const float* a, const float* b, float weight, int width, float* sum,
              float* count) {
  constexpr float nearSurface = 0.06F;
  for (int u = 0; u < width; ++u) {
    const float c = middle[u];
    const bool surface = std::max(std::abs(a[u] - c), std::abs(b[u] - c)) < nearSurface * c;
    sum[u] += surface ? 0.5F * (a[u] - b[u]) : 0.F;
    count[u] += surface ? weight : 0.F;
  }
}

ESTANCIA_MULTIVERSION
void normalRow(const float* w, const float* x, float y, const float* across, const float* countAcross,
               const float* down, const float* countDown, float fx, float fy, int width, float* nx, float* ny,
               float* nz) {
  for (int u = 0; u < width; ++u) {
    const bool known = (countAcross[u] > 0) & (countDown[u] > 0);
    const float a = across[u] / std::max(countAcross[u], 1.F) * fx;
    const float b = down[u] / std::max(countDown[u], 1.F) * fy;
    const float c = w[u] - a * x[u] - b * y;
    const float scale = known ? 1 / std::sqrt(std::max(a * a + b * b + c * c, 1e-30F)) : 0.F;
    nx[u] = a * scale;
    ny[u] = b * scale;
    nz[u] = c * scale;
  }
}

}  // namespace

HalfImage halve(const InverseDepth& grid, double tolerance, int threads) {
  HalfImage half;
  half.width = (grid.camera.width + 1) / 2;
  half.height = (grid.camera.height + 1) / 2;
  half.pixelArea = 4 / (grid.camera.fx * grid.camera.fy);
  for (int u = 0; u < grid.camera.width; u += 2) half.x.push_back(grid.slopeX[static_cast<std::size_t>(u)]);
  for (int v = 0; v < grid.camera.height; v += 2) half.y.push_back(grid.slopeY[static_cast<std::size_t>(v)]);
  const std::size_t n = half.row(half.height);
  for (auto* image : {&half.w, &half.nx, &half.ny, &half.nz, &half.near}) image->resize(n);
  const auto width = static_cast<std::size_t>(half.width);
  const auto fx = static_cast<float>(grid.camera.fx), fy = static_cast<float>(grid.camera.fy);
  inBands(half.height, threads, [&](int first, int last) {
    const auto full = static_cast<std::size_t>(grid.camera.width);
    std::vector<float> across(full), countAcross(full), down(full), countDown(full), normals[3];
    for (auto& n3 : normals) n3.resize(full);
    for (int v = first; v < last; ++v) {
      const float* w = &grid.smooth[grid.at(0, 2 * v)];
      for (auto* sums : {&across, &countAcross, &down, &countDown}) std::ranges::fill(*sums, 0.F);
      for (const int radius : {2, 5}) {
        const int steps = grid.pixels(radius);
        const std::ptrdiff_t below = steps * grid.stride;
        const auto weight = static_cast<float>(steps);
        addSlope(w, w + steps, w - steps, weight, grid.camera.width, across.data(), countAcross.data());
        addSlope(w, w + below, w - below, weight, grid.camera.width, down.data(), countDown.data());
      }
      normalRow(w, grid.slopeX.data(), grid.slopeY[2 * static_cast<std::size_t>(v)], across.data(),
                countAcross.data(), down.data(), countDown.data(), fx, fy, grid.camera.width,
                normals[0].data(), normals[1].data(), normals[2].data());
      const std::size_t at = half.row(v);
      for (std::size_t u = 0; u < width; ++u) {
        half.w[at + u] = w[2 * u];
        half.nx[at + u] = normals[0][2 * u];
        half.ny[at + u] = normals[1][2 * u];
        half.nz[at + u] = normals[2][2 * u];
        half.near[at + u] =
            w[2 * u] > 0 ? static_cast<float>(tolerance) * std::max(w[2 * u], 1 / w[2 * u]) : 0;
      }
    }
  });
  return half;
}

}  // namespace estancia
