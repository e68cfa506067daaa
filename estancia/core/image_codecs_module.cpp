// The module with the image codecs of TurboJPEG and OpenCV; image_codecs.cpp opens it.
// SPDX-License-Identifier: Apache-2.0
#include <turbojpeg.h>

#include <algorithm>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <string_view>
#include <type_traits>

#include "estancia/core/image_codecs.hpp"

namespace estancia {
namespace {

struct Destroy {
  void operator()(tjhandle decoder) const { tjDestroy(decoder); }
};
using JpegDecoder = std::unique_ptr<std::remove_pointer_t<tjhandle>, Destroy>;

/// Whether a JPEG file may contain an orientation: whether there is an Exif segment before the pixels.
bool hasExif(std::span<const unsigned char> bytes) {
  for (std::size_t at = 2; at + 10 <= bytes.size() && bytes[at] == 0xFF;) {
    const unsigned char marker = bytes[at + 1];
    constexpr unsigned char padding = 0xFF, pixels = 0xDA, application = 0xE1;
    constexpr std::string_view exif = "Exif";
    if (marker == pixels) return false;
    if (marker == application && std::equal(exif.begin(), exif.end(), &bytes[at + 4])) return true;
    const bool isAlone = marker == 0x01 || (marker >= 0xD0 && marker <= 0xD7);  // no length follows
    if (marker == padding)
      ++at;
    else
      at += isAlone ? 2 : 2 + (std::size_t{bytes[at + 2]} << 8 | bytes[at + 3]);
  }
  return false;
}

/// Gray and color JPEG files at 1/`divisor` of their size as BGR, to the same bits as cv::imdecode() in half
/// its time, which sorts the channels by itself. Empty where that is OpenCV's to do: other files, those that
/// may have to be turned, four channels, damage.
cv::Mat decodeJpeg(std::span<const unsigned char> bytes, int divisor) {
  if (bytes.size() < 4 || bytes[0] != 0xFF || bytes[1] != 0xD8 || hasExif(bytes)) return {};
  const JpegDecoder decoder(tjInitDecompress());
  const auto length = static_cast<unsigned long>(bytes.size());
  int width = 0, height = 0, subsampling = 0, colors = 0;
  if (!decoder ||
      tjDecompressHeader3(decoder.get(), bytes.data(), length, &width, &height, &subsampling, &colors) != 0 ||
      (colors != TJCS_YCbCr && colors != TJCS_GRAY && colors != TJCS_RGB))
    return {};
  const tjscalingfactor scale{1, divisor};
  cv::Mat image(TJSCALED(height, scale), TJSCALED(width, scale), CV_8UC3);
  const int failed = tjDecompress2(decoder.get(), bytes.data(), length, image.data, image.cols,
                                   static_cast<int>(image.step), image.rows, TJPF_BGR, TJFLAG_ACCURATEDCT);
  return failed != 0 ? cv::Mat() : image;  // tjGetErrorCode() does not report how much is missing
}

class Codecs final : public ImageCodecs {
 public:
  cv::Mat decode(std::span<const unsigned char> bytes, DecodedAs as) const override {
    if (as == DecodedAs::stored) return cv::imdecode(wrap(bytes), cv::IMREAD_UNCHANGED);
    cv::Mat image = decodeJpeg(bytes, 1);
    return image.empty() ? cv::imdecode(wrap(bytes), cv::IMREAD_COLOR | cv::IMREAD_ANYDEPTH) : image;
  }

  cv::Mat decodeReduced(std::span<const unsigned char> bytes, int divisor) const override {
    cv::Mat image = decodeJpeg(bytes, divisor);
    if (!image.empty()) return image;
    return cv::imdecode(wrap(bytes), divisor == 2   ? cv::IMREAD_REDUCED_COLOR_2
                                     : divisor == 4 ? cv::IMREAD_REDUCED_COLOR_4
                                                    : cv::IMREAD_REDUCED_COLOR_8);
  }

  std::vector<unsigned char> encodeJpeg(const cv::Mat& bgr, int quality) const override {
    std::vector<unsigned char> jpeg;
    if (!cv::imencode(".jpg", bgr, jpeg, {cv::IMWRITE_JPEG_QUALITY, quality})) jpeg.clear();
    return jpeg;
  }

 private:
  static cv::Mat wrap(std::span<const unsigned char> bytes) {
    return cv::Mat(1, static_cast<int>(bytes.size()), CV_8U,
                   const_cast<unsigned char*>(bytes.data()));  // only read
  }
};

}  // namespace
}  // namespace estancia

extern "C" __attribute__((visibility("default"))) const estancia::ImageCodecs* estanciaImageCodecs() {
  static const estancia::Codecs codecs;
  return &codecs;
}
