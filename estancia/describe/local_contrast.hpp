// Local contrast normalization: the preprocessing of GIST.
#pragma once

#include <opencv2/core/mat.hpp>

namespace estancia::describe {

/// `gray` (CV_32F, square, even, 0 to 255) in logarithms, without what varies slower than 4 cycles an image,
/// divided by 0.2 + the standard deviation around each pixel (Oliva, Torralba: prefilt, cut-off 4).
cv::Mat withEqualContrast(const cv::Mat& gray);

}  // namespace estancia::describe
