// SPDX-License-Identifier: Apache-2.0
#include "estancia/segmentation/segment_samples.hpp"

#include <algorithm>
#include <opencv2/core.hpp>
#include <tuple>

#include "estancia/core/cores.hpp"
#include "estancia/core/parallel.hpp"

namespace estancia {
namespace {

// Images may have thousands of segments, and segments are compared in pairs: this bounds the work. A kitchen
// has about 50 segments.
constexpr std::size_t maxSegmentSamples = 512;
constexpr double minSampledArea = 100;                     // [square pixels]
constexpr std::size_t maxSurface = 1500, maxBorder = 256;  // points of a segment

void thin(std::vector<cv::Point3f>& points, std::size_t max) {
  if (points.size() <= max) return;
  for (std::size_t i = 0; i < max; ++i) points[i] = points[i * points.size() / max];
  points.resize(max);
}

/// Segments that are large enough, at most maxSegmentSamples of them; ascending.
std::vector<std::uint32_t> largeSegments(const Segmentation& segments, double minPixels) {
  std::vector<std::uint32_t> large;
  for (std::uint32_t i = 1; i < segments.sizes.size(); ++i)
    if (segments.sizes[i] >= minPixels) large.push_back(i);
  if (large.size() <= maxSegmentSamples) return large;
  std::ranges::nth_element(large, large.begin() + maxSegmentSamples, [&](std::uint32_t a, std::uint32_t b) {
    return std::tuple(segments.sizes[b], a) < std::tuple(segments.sizes[a], b);
  });
  large.resize(maxSegmentSamples);
  std::ranges::sort(large);
  return large;
}

}  // namespace

std::vector<SegmentSamples> sampleSegments(const InverseDepth& grid, const Mask& mask,
                                           const Segmentation& segments) {
  std::vector<SegmentSamples> samples;
  std::vector<std::uint32_t> sampleOf(segments.sizes.size()), skip(segments.sizes.size());
  for (const std::uint32_t i : largeSegments(segments, grid.area(minSampledArea))) {
    samples.emplace_back().segment = i;
    sampleOf[i] = static_cast<std::uint32_t>(samples.size());
  }
  const auto stride = static_cast<std::size_t>(grid.stride);
  mask.eachPixel([&](std::size_t i) {
    const std::uint32_t label = segments.labels[i];
    if (sampleOf[label] == 0) return;
    SegmentSamples& segment = samples[sampleOf[label] - 1];
    if (skip[label]-- == 0) {
      skip[label] = segments.sizes[label] / maxSurface;
      segment.surface.push_back(grid.point(i));
    }
    if (segments.labels[i - 1] != label || segments.labels[i + 1] != label ||
        segments.labels[i - stride] != label || segments.labels[i + stride] != label)
      segment.border.push_back(grid.point(i));
  });
  for (SegmentSamples& segment : samples) {
    thin(segment.border, maxBorder);
    for (const cv::Point3f& p : segment.border) {
      segment.x.push_back(p.x);
      segment.y.push_back(p.y);
      segment.z.push_back(p.z);
      segment.box.add(p);
    }
  }
  return samples;
}

void mergePairs(std::size_t count, const FindPairs& find, const Mask& mask, int threads,
                Segmentation& segments) {
  std::vector<std::vector<std::pair<std::uint32_t, std::uint32_t>>> found(count);
  inParallel(count, static_cast<std::size_t>(threads > 0 ? threads : usableCores()),
             [&](std::size_t i) { found[i] = find(i); });
  DisjointSets sets(segments.sizes.size());
  for (const auto& pairs : found)
    for (const auto& [a, b] : pairs) sets.join(a, b);
  renumber(mask, segments, sets);
}

}  // namespace estancia
