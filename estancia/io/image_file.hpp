// One image file, checked before it is decoded.
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>

namespace estancia::io {

/// Reads an image as BGR, 8 bits, 3 channels, never empty; safe to call from several threads. Gray becomes
/// three equal channels, alpha is dropped, CMYK is converted, 16 bits are scaled from [0, 65535], float
/// (TIFF) from [0, 1]. The EXIF orientation is applied, so that the image stands upright as every viewer
/// shows it. Throws Error when the file cannot be read or is no complete image (see inspectImage).
cv::Mat readImage(const std::filesystem::path& file);

/// Reads an equirectangular panorama: OpenEXR and Radiance as linear float BGR (CV_32FC3), other images as
/// readImage.
/// `.js` files hold any of these as a data URI (`export default 'data:application/exr;base64,…'`). Throws
/// Error.
cv::Mat readPanorama(const std::filesystem::path& file);

/// The pixels of a complete image file as OpenCV decodes them under `flags` (cv::IMREAD_…), never empty.
/// Throws Error.
cv::Mat decodeImage(const std::filesystem::path& file, int flags);

/// Any image that OpenCV yields as BGR, 8 bits, 3 channels, scaled as readImage says.
cv::Mat toBgr8(cv::Mat image);

}  // namespace estancia::io
