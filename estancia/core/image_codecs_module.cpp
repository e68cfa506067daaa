// The module with OpenCV's image codecs; image_codecs.cpp opens it.
// SPDX-License-Identifier: Apache-2.0
#include <opencv2/imgcodecs.hpp>

#include "estancia/core/image_codecs.hpp"

namespace estancia {
namespace {

class OpencvCodecs final : public ImageCodecs {
 public:
  cv::Mat decode(std::span<const unsigned char> bytes, DecodedAs as) const override {
    const cv::Mat buffer(1, static_cast<int>(bytes.size()), CV_8U,
                         const_cast<unsigned char*>(bytes.data()));  // only read
    return cv::imdecode(
        buffer, as == DecodedAs::color ? cv::IMREAD_COLOR | cv::IMREAD_ANYDEPTH : cv::IMREAD_UNCHANGED);
  }

  std::vector<unsigned char> encodeJpeg(const cv::Mat& bgr, int quality) const override {
    std::vector<unsigned char> jpeg;
    if (!cv::imencode(".jpg", bgr, jpeg, {cv::IMWRITE_JPEG_QUALITY, quality})) jpeg.clear();
    return jpeg;
  }
};

}  // namespace
}  // namespace estancia

extern "C" __attribute__((visibility("default"))) const estancia::ImageCodecs* estanciaImageCodecs() {
  static const estancia::OpencvCodecs codecs;
  return &codecs;
}
