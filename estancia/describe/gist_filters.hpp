// Gabor filters: those of GIST, and their mean responses.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

namespace estancia::describe {

/// Side of the resized image [pixels].
constexpr int gistSide = 256;
constexpr int gistBlocks = 4, gistScales = 4, gistOrientations = 8;

/// `image` is CV_32F, gistSide × gistSide. A number a scale, orientation and block, in that order.
std::vector<float> meanAnswers(const cv::Mat& image);

}  // namespace estancia::describe
