// Grown image: an image of floor cells with a border of empty ones. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>
#include <opencv2/core/matx.hpp>

namespace estancia {

/// `image` with a border of so many empty cells, as FloorCells::cover() returns.
cv::Mat grown(const cv::Mat& image, const cv::Vec4i& border);

}  // namespace estancia
