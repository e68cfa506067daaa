// Image encoding: JPEG thumbnails for maps and reports, PNG files.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <string_view>
#include <vector>

namespace estancia {

/// The image as a JPEG, reduced to at most `width` pixels width. Throws Error when it cannot be encoded.
std::vector<unsigned char> encodeImage(const cv::Mat& bgr, int width = 192);

/// The first bytes of a PNG file.
constexpr std::string_view pngStart = "\x89PNG\r\n";

/// Writes a PNG file, whole or not at all. Throws Error when it cannot.
void writePng(const cv::Mat& bgr, const std::filesystem::path& file);

}  // namespace estancia
