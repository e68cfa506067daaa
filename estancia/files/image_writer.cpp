// SPDX-License-Identifier: Apache-2.0
#include "estancia/files/image_writer.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "estancia/core/fail.hpp"
#include "estancia/core/image_codecs.hpp"
#include "estancia/core/output_file.hpp"
#include "estancia/core/png.hpp"

namespace estancia {

std::vector<unsigned char> encodeImage(const cv::Mat& bgr, int width) {
  cv::Mat small = bgr;
  if (bgr.cols > width) {
    const int height = std::max(1, static_cast<int>(std::lround(1.0 * bgr.rows * width / bgr.cols)));
    cv::resize(bgr, small, {width, height}, 0, 0, cv::INTER_AREA);
  }
  constexpr int quality = 82;
  std::vector<unsigned char> jpeg = imageCodecs().encodeJpeg(small, quality);
  if (jpeg.empty())
    throw Error(ErrorCode::missingDependency, "cannot encode JPEG; OpenCV was built without it");
  return jpeg;
}

void writePng(const cv::Mat& bgr, const std::filesystem::path& file) {
  if (bgr.empty()) fail(ErrorCode::invalidInput, "{}: the image to write is empty", file.string());
  const std::vector<unsigned char> png = toPng(bgr);
  writeWhole(file, {reinterpret_cast<const char*>(png.data()), png.size()});
}

}  // namespace estancia
