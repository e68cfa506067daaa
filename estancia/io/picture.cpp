#include "estancia/io/picture.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "estancia/core/error.hpp"

namespace estancia {

std::vector<unsigned char> encodePicture(const cv::Mat& bgr, int width) {
  cv::Mat small = bgr;
  if (bgr.cols > width) {
    const int height = std::max(1, static_cast<int>(std::lround(1.0 * bgr.rows * width / bgr.cols)));
    cv::resize(bgr, small, {width, height}, 0, 0, cv::INTER_AREA);
  }
  constexpr int quality = 82;
  std::vector<unsigned char> jpeg;
  if (!cv::imencode(".jpg", small, jpeg, {cv::IMWRITE_JPEG_QUALITY, quality}))
    throw Error("a picture could not be encoded as JPEG; was OpenCV built without it?");
  return jpeg;
}

}  // namespace estancia
