// PNG: images of our own files, and for other programs, by libpng alone. A map is asked without image codecs.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>
#include <span>
#include <vector>

namespace estancia {

/// The image, 8 or 16 unsigned bits in 1 (gray), 3 (BGR) or 4 (BGRA) channels, as a PNG file that loses
/// nothing; at the fastest level, which takes the fourth part of the time of libpng's own, for hardly more
/// bytes. Throws Error (invalidInput) on any other image and on an empty one.
std::vector<unsigned char> toPng(const cv::Mat& image);

/// The pixels (CV_8U or CV_16U) of a gray PNG file; empty unless it is one, whole, and of at most `most`
/// pixels in width and height. The size is read from its header: nothing larger is decoded, nor is a file
/// with more than 64 kB in a chunk beside the pixels (texts, a color profile).
cv::Mat fromPng(std::span<const unsigned char> png, const cv::Size& most);

}  // namespace estancia
