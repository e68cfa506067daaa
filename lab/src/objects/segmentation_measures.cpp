// SPDX-License-Identifier: Apache-2.0
#include "objects/segmentation_measures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "estancia/core/error.hpp"
#include "objects/optimal_assignment.hpp"

namespace estancia::experiments {
namespace {

constexpr double boundaryShare = 0.003;  // share of the image's diagonal
constexpr double threeQuarters = 0.75;

/// A set of pixels with its boundary, in the part of the image around it.
struct Outline {
  std::size_t pixels = 0;
  cv::Rect box;           ///< box of `edge` and `near`
  cv::Mat edge;           ///< 1 on its boundary
  cv::Mat near;           ///< 1 close to its boundary
  double edgePixels = 0;  ///< pixels of the boundary
};

cv::Mat disc(int radius) {
  cv::Mat_<std::uint8_t> mask(2 * radius + 1, 2 * radius + 1);
  for (int y = -radius; y <= radius; ++y)
    for (int x = -radius; x <= radius; ++x) mask(y + radius, x + radius) = x * x + y * y <= radius * radius;
  return mask;
}

/// A pixel is on the boundary where its neighbor to the right, below, or both, is on the other side (Martin's
/// seg2bmap). The boundary of what the image's edge cuts is not the edge.
Outline outlineOf(const PixelSet& pixels, const cv::Size& image, int radius) {
  Outline outline{pixels.size(), {}, {}, {}, 0};
  for (const std::uint32_t p : pixels)
    outline.box |= cv::Rect(static_cast<int>(p) % image.width, static_cast<int>(p) / image.width, 1, 1);
  const int margin = radius + 1;
  outline.box -= cv::Point(margin, margin);
  outline.box += cv::Size(2 * margin, 2 * margin);
  outline.box &= cv::Rect({}, image);
  const cv::Rect& box = outline.box;
  cv::Mat_<std::uint8_t> in(box.size(), 0), edge(box.size(), 0);
  for (const std::uint32_t p : pixels)
    in(static_cast<int>(p) / image.width - box.y, static_cast<int>(p) % image.width - box.x) = 1;
  for (int v = 0; v < box.height; ++v)
    for (int u = 0; u < box.width; ++u) {
      const int right = std::min(u + 1, box.width - 1), below = std::min(v + 1, box.height - 1);
      edge(v, u) = in(v, u) != in(v, right) || in(v, u) != in(below, u) || in(v, u) != in(below, right);
    }
  outline.edge = edge;
  cv::dilate(edge, outline.near, disc(radius));
  outline.edgePixels = cv::countNonZero(edge);
  return outline;
}

std::vector<Outline> outlinesOf(const std::vector<PixelSet>& sets, const cv::Size& image) {
  const auto radius = static_cast<int>(std::ceil(boundaryShare * std::hypot(image.width, image.height)));
  std::vector<Outline> outlines;
  for (const PixelSet& set : sets)
    if (!set.empty()) outlines.push_back(outlineOf(set, image, radius));
  return outlines;
}

/// Pixels of one's boundary that are close to the other's.
double matched(const Outline& one, const Outline& other) {
  const cv::Rect common = one.box & other.box;
  if (common.empty()) return 0;
  return cv::countNonZero(one.edge(common - one.box.tl()) & other.near(common - other.box.tl()));
}

PrecisionRecall of(double precision, double recall) {
  return {precision, recall, precision + recall > 0 ? 2 * precision * recall / (precision + recall) : 0};
}

}  // namespace

SegmentationMeasures measureClusters(const cv::Mat& truth, const std::vector<PixelSet>& clusters) {
  const std::vector<PixelSet> objects = objectsOf(truth);
  std::vector<PixelSet> found;
  std::ranges::copy_if(clusters, std::back_inserter(found), [](const PixelSet& set) { return !set.empty(); });
  if (objects.empty() || found.empty()) {
    const PrecisionRecall empty = of(found.empty() ? 1 : 0, objects.empty() ? 1 : 0);
    return {empty, empty, 0};
  }
  cv::Mat_<int> row(truth.size(), -1);
  for (std::size_t o = 0; o < objects.size(); ++o)
    for (const std::uint32_t p : objects[o]) row.ptr<int>()[p] = static_cast<int>(o);
  const auto rows = static_cast<int>(objects.size()), columns = static_cast<int>(found.size());
  cv::Mat_<double> common(rows, columns, 0.), f(rows, columns, 0.);
  double ours = 0, theirs = 0;
  for (int c = 0; c < columns; ++c) {
    for (const std::uint32_t p : found[static_cast<std::size_t>(c)]) {
      if (p >= truth.total())
        throw Error(ErrorCode::invalidInput,
                    fmt::format("a cluster has the pixel {} of an image of {}", p, truth.total()));
      if (const int o = row.ptr<int>()[p]; o >= 0) ++common(o, c);
    }
    const auto size = static_cast<double>(found[static_cast<std::size_t>(c)].size());
    ours += size;
    for (int o = 0; o < rows; ++o)
      f(o, c) = 2 * common(o, c) / (size + static_cast<double>(objects[static_cast<std::size_t>(o)].size()));
  }
  for (const PixelSet& object : objects) theirs += static_cast<double>(object.size());

  const std::vector<Outline> a = outlinesOf(objects, truth.size()), b = outlinesOf(found, truth.size());
  double inCommon = 0, edgesOurs = 0, edgesTheirs = 0, allOurs = 0, allTheirs = 0;
  for (const Outline& outline : b) allOurs += outline.edgePixels;
  for (const Outline& outline : a) allTheirs += outline.edgePixels;
  SegmentationMeasures measures;
  for (const auto& [o, c] : optimalAssignment(f)) {
    const auto r = static_cast<int>(o), k = static_cast<int>(c);
    inCommon += common(r, k);
    edgesOurs += matched(b[c], a[o]);
    edgesTheirs += matched(a[o], b[c]);
    measures.atThreeQuarters += f(r, k) > threeQuarters ? 1 : 0;
  }
  measures.overlap = of(inCommon / ours, inCommon / theirs);
  measures.boundary = of(edgesOurs / std::max(allOurs, 1.), edgesTheirs / std::max(allTheirs, 1.));
  return measures;
}

}  // namespace estancia::experiments
