// Segment colors: the colors of a depth image's pixels, in which light matters little.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>

namespace estancia {

/// Color of each pixel: lightness, weighted, and chroma over lightness, which shading does not change (in CIE
/// Lab, L + 16, a and b all grow with the cube root of the light). Empty without an image.
using SegmentColors = cv::Mat_<cv::Vec3f>;

/// The least change of color over 4 pixels at an edge of color.
constexpr double colorEdge = 7;

/// `image`: BGR, or empty; of the same view as the depth image of `size`, in any size.
SegmentColors segmentColors(const cv::Mat& image, const cv::Size& size);

}  // namespace estancia
