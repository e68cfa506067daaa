// SPDX-License-Identifier: Apache-2.0
#include "estancia/io/image_writer.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "estancia/core/fail.hpp"
#include "estancia/core/output_file.hpp"

namespace estancia {

std::vector<unsigned char> encodeImage(const cv::Mat& bgr, int width) {
  cv::Mat small = bgr;
  if (bgr.cols > width) {
    const int height = std::max(1, static_cast<int>(std::lround(1.0 * bgr.rows * width / bgr.cols)));
    cv::resize(bgr, small, {width, height}, 0, 0, cv::INTER_AREA);
  }
  constexpr int quality = 82;
  std::vector<unsigned char> jpeg;
  if (!cv::imencode(".jpg", small, jpeg, {cv::IMWRITE_JPEG_QUALITY, quality}))
    throw Error(ErrorCode::missingDependency, "cannot encode JPEG; OpenCV was built without it");
  return jpeg;
}

void writePng(const cv::Mat& bgr, const std::filesystem::path& file) {
  std::vector<unsigned char> png;
  if (bgr.empty() || !cv::imencode(".png", bgr, png))
    fail(ErrorCode::invalidInput, "{}: the image cannot be encoded as PNG", file.string());
  writeWhole(file, {reinterpret_cast<const char*>(png.data()), png.size()});
}

}  // namespace estancia
