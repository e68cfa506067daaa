// SPDX-License-Identifier: Apache-2.0
#include "estancia/labelers/default_boxes.hpp"

#include <algorithm>
#include <cmath>

namespace estancia {
namespace {

constexpr double smallestScale = 0.2, largestScale = 0.95;  // scales of the first and the last grid
constexpr double ofFirstGrid = 0.1;                         // scale of its square box
constexpr double wellOverlapped = 0.4, nearlyBest = 0.8;

struct BoxShape {
  double scale, aspect;
};

std::vector<BoxShape> shapesOf(std::size_t grid, std::size_t grids) {
  const auto scale = [grids](std::size_t k) {
    if (k >= grids) return 1.0;
    return grids < 2 ? smallestScale
                     : smallestScale + (largestScale - smallestScale) * static_cast<double>(k) /
                                           static_cast<double>(grids - 1);
  };
  const double here = scale(grid);
  if (grid == 0) return {{ofFirstGrid, 1}, {here, 2}, {here, 0.5}};
  return {{here, 1}, {here, 2},       {here, 0.5},
          {here, 3}, {here, 1.0 / 3}, {std::sqrt(here * scale(grid + 1)), 1}};
}

double overlapOf(const cv::Rect2d& a, const cv::Rect2d& b) {
  const double both = (a & b).area(), all = a.area() + b.area() - both;
  return all > 0 ? both / all : 0;
}

}  // namespace

std::vector<cv::Rect2d> defaultBoxes(std::span<const int> grids) {
  std::vector<cv::Rect2d> boxes;
  for (std::size_t k = 0; k < grids.size(); ++k) {
    const std::vector<BoxShape> shapes = shapesOf(k, grids.size());
    for (int row = 0; row < grids[k]; ++row)
      for (int column = 0; column < grids[k]; ++column)
        for (const BoxShape& shape : shapes) {
          const double width = shape.scale * std::sqrt(shape.aspect),
                       height = shape.scale / std::sqrt(shape.aspect);
          boxes.emplace_back((column + 0.5) / grids[k] - width / 2, (row + 0.5) / grids[k] - height / 2,
                             width, height);
        }
  }
  return boxes;
}

std::vector<std::size_t> boxesOf(const cv::Rect2d& region, std::span<const cv::Rect2d> boxes) {
  double best = 0;
  for (const cv::Rect2d& box : boxes) best = std::max(best, overlapOf(region, box));
  std::vector<std::size_t> found;
  const double enough = std::min(wellOverlapped, nearlyBest * best);
  for (std::size_t i = 0; i < boxes.size() && best > 0; ++i)
    if (overlapOf(region, boxes[i]) >= enough) found.push_back(i);
  return found;
}

}  // namespace estancia
