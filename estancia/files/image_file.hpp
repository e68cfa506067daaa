// Image files: read any common format as 8-bit BGR; incomplete and oversized files are refused.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>

namespace estancia {

/// Reads an image as BGR, 8 bits, 3 channels, never empty; thread-safe. Gray becomes three equal channels,
/// alpha is dropped, CMYK is converted, 16 bits are scaled from [0, 65535], float (TIFF) from [0, 1]. EXIF
/// orientation is applied. Throws Error when it cannot be read, is incomplete or has more than 2^26 pixels.
cv::Mat readImage(const std::filesystem::path& file);

/// Like readImage(), but decodes a JPEG file at 1/2, 1/4 or 1/8 of its size, which is quicker to decode: at
/// the smallest whose shorter side is still `side` pixels. Other files, and smaller ones, as they are.
cv::Mat readReducedImage(const std::filesystem::path& file, int side);

}  // namespace estancia
