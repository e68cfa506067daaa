// Segment graph: which segments of a depth image lie beside each other, and how.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/matx.hpp>
#include <vector>

#include "estancia/segmentation/inverse_depth.hpp"
#include "estancia/segmentation/segments.hpp"

namespace estancia {

/// Color of each pixel: lightness, weighted, and chroma over lightness, which shading does not change (in CIE
/// Lab, L + 16, a and b all grow with the cube root of the light). Empty without an image.
using SegmentColors = cv::Mat_<cv::Vec3f>;

/// The least change of color over 4 pixels at an edge of color.
constexpr double colorEdge = 7;

/// `image`: BGR, or empty; of the same view as the depth image of `size`, in any size.
SegmentColors segmentColors(const cv::Mat& image, const cv::Size& size);

/// Share of 1/z by which adjacent pixels of two surfaces differ at least where one ends before the other.
constexpr float depthStep = 0.02F;

/// Two segments side by side in the image, a < b; segment 0 is all pixels with depth that have none.
struct SegmentEdge {
  std::uint32_t a = 0, b = 0;
  std::size_t contacts = 0;                ///< pairs of adjacent pixels of about one depth
  std::size_t aInFront = 0, bInFront = 0;  ///< pairs at a depth edge
  double height = 0;                       ///< mean height of the contacts, along `up` [m]
  double contrast = 0;                     ///< change of color over 4 pixels across the contacts, their mean
  /// The distance of a quarter of the pixels to the other segment, across at most three pixels without a
  /// segment [m]; infinite for segment 0.
  float gap = 0;
};

/// Ascending by a, b. Without colors there is no contrast.
std::vector<SegmentEdge> segmentGraph(const InverseDepth& grid, const Segmentation& segments,
                                      const cv::Vec3d& up, const SegmentColors& colors = {});

}  // namespace estancia
