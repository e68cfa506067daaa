// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "estancia/core/parallel.hpp"
#include "estancia/recognition/descriptors.hpp"

namespace estancia {
namespace {

constexpr int width = 8, rows = width + 1, columns = 2 * width + 1, length = rows * columns;
constexpr float supportCosine = 0.5F;
constexpr std::size_t minNeighbors = 5, together = 32;

/// Cylindrical coordinates of the neighbors around the normal: distance from it, and height. Each point is
/// interpolated between four cells.
void spin(const Surface& surface, std::uint32_t keypoint, float radius, std::vector<Neighbor>& buffer,
          float* image) {
  const cv::Point3f &p = surface.points()[keypoint], &axis = surface.normals()[keypoint];
  const auto near = surface.neighbors().within(p, radius, buffer);
  if (near.size() < minNeighbors) {
    std::fill_n(image, length, std::numeric_limits<float>::quiet_NaN());
    return;
  }
  // The cylinder that fits into the ball is as high as it is wide.
  const float cell = radius / width / std::sqrt(2.F), edge = cell * width;
  std::array<double, length> sums{};
  double total = 0;
  for (const Neighbor& n : near) {
    if (n.squared == 0 || std::abs(axis.dot(surface.normals()[n.index])) < supportCosine) continue;
    const float height = axis.dot(surface.points()[n.index] - p);
    const float away = std::sqrt(std::max(n.squared - height * height, 0.F));
    if (std::abs(height) >= edge || away >= edge) continue;
    const float column = height / cell + width, row = away / cell;
    const int c = std::min(static_cast<int>(column), columns - 2),
              r = std::min(static_cast<int>(row), rows - 2);
    const double b = column - static_cast<float>(c), a = row - static_cast<float>(r);
    double* const at = sums.data() + r * columns + c;
    at[0] += (1 - a) * (1 - b);
    at[columns] += a * (1 - b);
    at[1] += (1 - a) * b;
    at[columns + 1] += a * b;
    total += 1;
  }
  for (int i = 0; i < length; ++i)
    image[i] = total > 0 ? static_cast<float>(sums[static_cast<std::size_t>(i)] / total) : 0;
}

}  // namespace

void describeSpinImage(const Surface& surface, std::span<const std::uint32_t> keypoints, double radius,
                       int threads, std::vector<float>& values) {
  values.resize(keypoints.size() * length);
  inParallel((keypoints.size() + together - 1) / together, threads, Progress::none(),
             "stopped while a surface was described", [&](std::size_t chunk) {
               std::vector<Neighbor> buffer;
               const std::size_t end = std::min(keypoints.size(), (chunk + 1) * together);
               for (std::size_t i = chunk * together; i < end; ++i)
                 spin(surface, keypoints[i], static_cast<float>(radius), buffer, values.data() + i * length);
             });
}

}  // namespace estancia
