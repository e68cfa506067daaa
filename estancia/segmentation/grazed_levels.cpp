// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <utility>

#include "estancia/segmentation/segmentation_stages.hpp"

namespace estancia {
namespace {

constexpr double level = 0.17;       // sine of the slope of a level surface: 10°
constexpr double foreshortened = 4;  // pixels of a surface at a right angle to the ray: at 14°, normals fail

/// From a pixel to the one above it, as gravity has it.
std::ptrdiff_t stepUp(const InverseDepth& grid, const cv::Vec3d& up) {
  if (std::abs(up[0]) > std::abs(up[1])) return up[0] > 0 ? 1 : -1;
  return up[1] > 0 ? grid.stride : -grid.stride;
}

}  // namespace

void dropGrazedLevels(const InverseDepth& grid, const cv::Vec3d& up, PlaneRemoval& removal) {
  if (!(cv::norm(up) > 0)) return;
  const std::ptrdiff_t step = stepUp(grid, up);
  const double focal = std::abs(step) == 1 ? grid.camera.fx : grid.camera.fy;
  // Whether the surface from a pixel to the one above it is level and recedes.
  const auto recedes = [&](std::size_t i, std::size_t above) {
    if (!(grid.raw[i] > 0) || !(grid.raw[above] > 0) || grid.raw[above] >= grid.raw[i]) return false;
    const cv::Point3f p = grid.point(i), q = grid.point(above);
    const cv::Vec3d along(q.x - p.x, q.y - p.y, q.z - p.z);
    const double length = cv::norm(along), z = q.z;
    return length > foreshortened * z / focal + differenceNoise * z * z &&
           std::abs(along.dot(up)) < level * length;
  };
  std::vector<std::uint8_t> in = removal.rest.in;
  removal.rest.eachPixel([&](std::size_t i) {
    const auto at = static_cast<std::ptrdiff_t>(i);
    const auto above = static_cast<std::size_t>(at + step), below = static_cast<std::size_t>(at - step);
    if (recedes(i, above) && recedes(below, i)) in[i] = 0;
  });
  removal.rest = Mask(grid, std::move(in));
}

}  // namespace estancia
