// Compressed depth: the compressedDepth transport of ROS, 16 bits as PNG or RVL.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>

#include "estancia/ros/messages.hpp"

namespace estancia::io {

/// Meters, CV_32F, 0 where unknown. The data begin with a header of 12 bytes: a format, and two numbers a and
/// b that the inverse depth of a float image was quantized with, z = a / (v − b). Then a PNG file, or RVL
/// (Wilson 2017, "Fast Lossless Depth Image Compression"). `unitsPerMeter`: of images of 16 bits; 0:
/// millimeters. Throws Error: malformedFile, unsupportedFile, tooLarge.
cv::Mat readCompressedDepth(const ros::CompressedImageMessage& message, double unitsPerMeter);

}  // namespace estancia::io
