// Image codecs: JPEG, PNG, TIFF and what else OpenCV reads, from a module that is opened for the first image.
// They bring a hundred and fifty shared libraries, which cost each start of a program a tenth of a second.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>
#include <span>
#include <vector>

namespace estancia {

/// Pixel format of a decoded image file.
enum class DecodedAs {
  stored,  ///< their channels and depth
  color,   ///< BGR in their depth; the EXIF orientation is applied
};

/// Codecs of TurboJPEG (JPEG to BGR) and OpenCV; thread-safe. All functions may throw cv::Exception.
class ImageCodecs {
 public:
  virtual ~ImageCodecs() = default;
  /// Empty where the bytes are no image that OpenCV reads.
  virtual cv::Mat decode(std::span<const unsigned char> bytes, DecodedAs as) const = 0;
  /// BGR, 8 bits, at 1/`divisor` of the size (2, 4, 8), which libjpeg decodes much faster. Empty as above.
  virtual cv::Mat decodeReduced(std::span<const unsigned char> bytes, int divisor) const = 0;
  /// Encodes a JPEG file of this quality, 1 to 100; empty where OpenCV was built without JPEG.
  virtual std::vector<unsigned char> encodeJpeg(const cv::Mat& bgr, int quality) const = 0;
};

/// Opens the module at the first call. Throws Error (missingDependency) where it cannot.
const ImageCodecs& imageCodecs();

}  // namespace estancia
