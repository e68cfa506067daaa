// Area resize: an image shrunk so that each pixel is the mean of the area that it covers.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>

namespace estancia {

/// cv::resize() with INTER_AREA of an image CV_8UC3 to a size that is nowhere larger, three times as fast
/// where the ratios are no integers; its values are within one of OpenCV's. Throws cv::Exception on other
/// types and sizes.
cv::Mat resizeByArea(const cv::Mat& image, cv::Size size);

}  // namespace estancia
