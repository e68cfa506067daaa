// Images that are written: small ones for maps and reports, and files.
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <string_view>
#include <vector>

namespace estancia {

/// The image as a JPEG of at most `width` pixels width. Throws Error when it cannot be encoded.
std::vector<unsigned char> encodeImage(const cv::Mat& bgr, int width = 192);

/// What a PNG file begins with.
constexpr std::string_view pngStart = "\x89PNG\r\n";

/// Writes the image as a PNG file, whole or not at all. Throws Error when it cannot.
void writePng(const std::filesystem::path& file, const cv::Mat& bgr);

}  // namespace estancia
