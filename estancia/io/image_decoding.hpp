// Image decoding: complete image files to pixels, panoramas, and conversion to 8-bit BGR.
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>

namespace estancia::io {

/// Reads an equirectangular panorama: OpenEXR and Radiance as linear float BGR (CV_32FC3), other formats as
/// readImage(). A `.js` file holds any of these as a data URI (`export default 'data:…;base64,…'`). Throws
/// Error.
cv::Mat readPanorama(const std::filesystem::path& file);

/// The pixels of a complete image file as OpenCV decodes them under `flags` (cv::IMREAD_…), never empty.
/// Throws Error.
cv::Mat decodeImage(const std::filesystem::path& file, int flags);

/// Any image type of OpenCV as BGR, 8 bits, 3 channels, scaled as readImage() says.
cv::Mat toBgr8(cv::Mat image);

}  // namespace estancia::io
