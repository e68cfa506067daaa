#include "estancia/cloud/shapes.hpp"

#include <algorithm>

#include "estancia/core/cores.hpp"
#include "estancia/core/parallel.hpp"

namespace estancia {
namespace {

constexpr double kLeastShape = 100;                            // [square pixels]
constexpr std::size_t kMostSurface = 1500, kMostBorder = 256;  // points that stand for a piece

void thin(std::vector<cv::Point3f>& points, std::size_t most) {
  if (points.size() <= most) return;
  for (std::size_t i = 0; i < most; ++i) points[i] = points[i * points.size() / most];
  points.resize(most);
}

}  // namespace

std::vector<Shape> shapesOf(const InverseDepth& grid, const Mask& mask, const Pieces& pieces) {
  std::vector<Shape> shapes;
  std::vector<std::uint32_t> shapeOf(pieces.sizes.size()), skip(pieces.sizes.size());
  for (std::uint32_t i = 1; i < pieces.sizes.size(); ++i) {
    if (pieces.sizes[i] < grid.area(kLeastShape)) continue;
    shapes.emplace_back().piece = i;
    shapeOf[i] = static_cast<std::uint32_t>(shapes.size());
  }
  const auto stride = static_cast<std::size_t>(grid.stride);
  mask.eachPixel([&](std::size_t i) {
    const std::uint32_t label = pieces.labels[i];
    if (shapeOf[label] == 0) return;
    Shape& shape = shapes[shapeOf[label] - 1];
    if (skip[label]-- == 0) {
      skip[label] = pieces.sizes[label] / kMostSurface;
      shape.surface.push_back(grid.point(i));
    }
    if (pieces.labels[i - 1] != label || pieces.labels[i + 1] != label ||
        pieces.labels[i - stride] != label || pieces.labels[i + stride] != label)
      shape.border.push_back(grid.point(i));
  });
  for (Shape& shape : shapes) {
    thin(shape.border, kMostBorder);
    shape.low = shape.high = shape.border.front();
    for (const cv::Point3f& p : shape.border) {
      shape.x.push_back(p.x);
      shape.y.push_back(p.y);
      shape.z.push_back(p.z);
      shape.low = {std::min(shape.low.x, p.x), std::min(shape.low.y, p.y), std::min(shape.low.z, p.z)};
      shape.high = {std::max(shape.high.x, p.x), std::max(shape.high.y, p.y), std::max(shape.high.z, p.z)};
    }
  }
  return shapes;
}

void joinPartners(const std::vector<Shape>& shapes, const Mask& mask, int threads,
                  const std::function<std::vector<std::uint32_t>(const Shape&)>& partners, Pieces& pieces) {
  std::vector<std::vector<std::uint32_t>> found(shapes.size());
  inParallel(shapes.size(), static_cast<std::size_t>(threads > 0 ? threads : usableCores()),
             [&](std::size_t i) { found[i] = partners(shapes[i]); });
  DisjointSets sets(pieces.sizes.size());
  for (std::size_t i = 0; i < shapes.size(); ++i)
    for (const std::uint32_t other : found[i]) sets.join(shapes[i].piece, other);
  renumber(mask, pieces, sets);
}

}  // namespace estancia
