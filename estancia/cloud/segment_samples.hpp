// Some points that stand for each piece of a depth image.
#pragma once

#include <cstdint>
#include <functional>
#include <opencv2/core/types.hpp>
#include <utility>
#include <vector>

#include "estancia/cloud/inverse_depth.hpp"
#include "estancia/cloud/segments.hpp"

namespace estancia {

// Images may fall into thousands of pieces, and pieces are compared by pairs: these bound the work whatever
// the image. A kitchen has 50 shapes and 100 pairs that are near.
constexpr std::size_t kMaxSegmentSamples = 512;
constexpr std::size_t kMaxPairs = 4096;

struct SegmentSamples {
  std::uint32_t piece;
  std::vector<cv::Point3f> surface;  ///< spread over it, 1500 at most
  std::vector<cv::Point3f> border;   ///< along its border in the image, 256 at most
  cv::Point3f low, high;             ///< of the border
  std::vector<float> x, y, z;        ///< the border by coordinate, so that many points are compared at once
};

/// Of the pieces that are not too small to tell, in their order; of more than kMaxSegmentSamples the largest.
std::vector<SegmentSamples> sampleSegments(const InverseDepth& grid, const Mask& mask,
                                           const Segmentation& pieces);

/// Which shapes, by their indices, come within `farthest` [m] of each other by the boxes around their
/// borders, but do not touch in the image; of more than kMaxPairs those whose boxes are nearest.
std::vector<std::pair<std::uint32_t, std::uint32_t>> nearPairs(const std::vector<SegmentSamples>& shapes,
                                                               const Segmentation& pieces, double farthest);

/// Joins the pairs of pieces that find(i) names for each i below `count`; asks on several threads.
using FindPairs = std::function<std::vector<std::pair<std::uint32_t, std::uint32_t>>(std::size_t)>;
void joinFound(std::size_t count, const FindPairs& find, const Mask& mask, int threads, Segmentation& pieces);

}  // namespace estancia
