// The Gabor filters of GIST, and their mean answers.
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

namespace estancia::describe {

constexpr int kGistSide = 256;  ///< of the image [pixels]
constexpr int kGistBlocks = 4, kGistScales = 4, kGistOrientations = 8;

/// `image` is CV_32F, kGistSide × kGistSide. A number a scale, orientation and block, in that order.
std::vector<float> meanAnswers(const cv::Mat& image);

}  // namespace estancia::describe
