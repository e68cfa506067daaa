#include "estancia/cloud/segment_samples.hpp"

#include <algorithm>
#include <opencv2/core.hpp>
#include <tuple>

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

double distanceOfBoxes(const SegmentSamples& a, const SegmentSamples& b) {
  const auto apart = [](float lowA, float highA, float lowB, float highB) {
    return std::max({0.F, lowB - highA, lowA - highB});
  };
  return cv::norm(cv::Point3f(apart(a.low.x, a.high.x, b.low.x, b.high.x),
                              apart(a.low.y, a.high.y, b.low.y, b.high.y),
                              apart(a.low.z, a.high.z, b.low.z, b.high.z)));
}

/// Pieces that are large enough, or the largest of these; ascending.
std::vector<std::uint32_t> largePieces(const Segmentation& pieces, double least) {
  std::vector<std::uint32_t> large;
  for (std::uint32_t i = 1; i < pieces.sizes.size(); ++i)
    if (pieces.sizes[i] >= least) large.push_back(i);
  if (large.size() <= kMaxSegmentSamples) return large;
  std::ranges::nth_element(large, large.begin() + kMaxSegmentSamples, [&](std::uint32_t a, std::uint32_t b) {
    return std::tuple(pieces.sizes[b], a) < std::tuple(pieces.sizes[a], b);
  });
  large.resize(kMaxSegmentSamples);
  std::ranges::sort(large);
  return large;
}

}  // namespace

std::vector<SegmentSamples> sampleSegments(const InverseDepth& grid, const Mask& mask,
                                           const Segmentation& pieces) {
  std::vector<SegmentSamples> shapes;
  std::vector<std::uint32_t> shapeOf(pieces.sizes.size()), skip(pieces.sizes.size());
  for (const std::uint32_t i : largePieces(pieces, grid.area(kLeastShape))) {
    shapes.emplace_back().piece = i;
    shapeOf[i] = static_cast<std::uint32_t>(shapes.size());
  }
  const auto stride = static_cast<std::size_t>(grid.stride);
  mask.eachPixel([&](std::size_t i) {
    const std::uint32_t label = pieces.labels[i];
    if (shapeOf[label] == 0) return;
    SegmentSamples& shape = shapes[shapeOf[label] - 1];
    if (skip[label]-- == 0) {
      skip[label] = pieces.sizes[label] / kMostSurface;
      shape.surface.push_back(grid.point(i));
    }
    if (pieces.labels[i - 1] != label || pieces.labels[i + 1] != label ||
        pieces.labels[i - stride] != label || pieces.labels[i + stride] != label)
      shape.border.push_back(grid.point(i));
  });
  for (SegmentSamples& shape : shapes) {
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

std::vector<std::pair<std::uint32_t, std::uint32_t>> nearPairs(const std::vector<SegmentSamples>& shapes,
                                                               const Segmentation& pieces, double farthest) {
  std::vector<std::tuple<double, std::uint32_t, std::uint32_t>> found;
  for (std::uint32_t i = 0; i < shapes.size(); ++i)
    for (std::uint32_t j = i + 1; j < shapes.size(); ++j) {
      const double distance = distanceOfBoxes(shapes[i], shapes[j]);
      if (distance <= farthest &&
          !std::ranges::binary_search(pieces.touching, std::pair(shapes[i].piece, shapes[j].piece)))
        found.emplace_back(distance, i, j);
    }
  if (found.size() > kMaxPairs) {
    std::ranges::nth_element(found, found.begin() + kMaxPairs);
    found.resize(kMaxPairs);
  }
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  pairs.reserve(found.size());
  for (const auto& [distance, i, j] : found) pairs.emplace_back(i, j);
  return pairs;
}

void joinFound(std::size_t count, const FindPairs& find, const Mask& mask, int threads,
               Segmentation& pieces) {
  std::vector<std::vector<std::pair<std::uint32_t, std::uint32_t>>> found(count);
  inParallel(count, static_cast<std::size_t>(threads > 0 ? threads : usableCores()),
             [&](std::size_t i) { found[i] = find(i); });
  DisjointSets sets(pieces.sizes.size());
  for (const auto& pairs : found)
    for (const auto& [a, b] : pairs) sets.join(a, b);
  renumber(mask, pieces, sets);
}

}  // namespace estancia
