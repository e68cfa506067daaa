// Segment samples: a bounded number of points of each segment of a depth image.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <opencv2/core/types.hpp>
#include <utility>
#include <vector>

#include "estancia/cloud/bounds.hpp"
#include "estancia/segmentation/inverse_depth.hpp"
#include "estancia/segmentation/segments.hpp"

namespace estancia {

struct SegmentSamples {
  std::uint32_t segment;
  std::vector<cv::Point3f> surface;  ///< spread over the segment, at most 1500
  std::vector<cv::Point3f> border;   ///< along its border in the image, at most 256
  Bounds<float> box;                 ///< box of the border
  std::vector<float> x, y, z;        ///< the border by coordinate, for SIMD
};

/// Samples the segments above a minimum size, in their order; at most the 512 largest.
std::vector<SegmentSamples> sampleSegments(const InverseDepth& grid, const Mask& mask,
                                           const Segmentation& segments);

/// Merges the pairs of segments that find(i) returns for each i below `count`; calls it on several threads.
using FindPairs = std::function<std::vector<std::pair<std::uint32_t, std::uint32_t>>(std::size_t)>;
void mergePairs(std::size_t count, const FindPairs& find, const Mask& mask, int threads,
                Segmentation& segments);

}  // namespace estancia
