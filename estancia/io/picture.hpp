// Small pictures for maps and reports.
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

namespace estancia {

/// The image as a JPEG of at most `width` pixels width. Throws Error when it cannot be encoded.
std::vector<unsigned char> encodePicture(const cv::Mat& bgr, int width = 192);

}  // namespace estancia
