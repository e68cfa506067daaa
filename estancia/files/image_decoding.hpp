// Image decoding: headers checked, complete image files to pixels, panoramas and their tone mapping.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <string>
#include <string_view>

#include "estancia/core/image_codecs.hpp"

namespace estancia::io {

struct ImageHeader {
  std::string format;  ///< "JPEG", "PNG", "BMP", "TIFF", "WebP", "PNM", "PFM", "OpenEXR", "Radiance"
  std::uint64_t width = 0, height = 0;

  bool isRadiance() const { return format == "OpenEXR" || format == "Radiance"; }
};

/// Recognizes the format by content, never by name, and reads the declared size, before a decoder allocates
/// memory. Throws Error, naming `file`, when the bytes are no image, declare no pixels or more than 2^26 (67
/// million), or end before the image does: decoders fill the rest of a truncated JPEG or TIFF with gray
/// without an error. Damage inside complete data is left to the decoders (PNG has checksums, JPEG has none).
ImageHeader inspectImage(std::string_view bytes, const std::string& file);

/// Reads an equirectangular panorama: OpenEXR, Radiance as linear float BGR (CV_32FC3), else as readImage().
/// A `.js` file holds one as a data URI (`export default 'data:…;base64,…'`). Throws Error.
cv::Mat readPanorama(const std::filesystem::path& file);

/// Converts a panorama (CV_32FC3 linear radiance, or an 8-bit image) to BGR, 8 bits, sRGB. Radiance is scaled
/// so that its log-average over the sphere becomes middle gray (0.18, Reinhard et al. 2002), then by
/// `exposure` [EV]; highlights above 0.6 are rolled off. 8-bit images are scaled by `exposure` only.
cv::Mat toneMap(cv::Mat panorama, double exposure);

/// The pixels of a whole image file with the channels and the depth that it has, never empty. Throws Error.
cv::Mat decodeImage(const std::filesystem::path& file);

/// The only channel of an image, as gray images are often saved with three; empty where these differ.
cv::Mat onlyChannel(const cv::Mat& image);

/// The pixels of an image file's bytes that inspectImage() has passed. Throws Error (malformedFile: `file`).
cv::Mat decodeImage(std::string_view bytes, DecodedAs as, const std::filesystem::path& file);

/// Any image type of OpenCV as BGR, 8 bits, 3 channels, scaled as by readImage().
cv::Mat toBgr8(cv::Mat image);

}  // namespace estancia::io
