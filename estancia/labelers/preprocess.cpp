// SPDX-License-Identifier: Apache-2.0
#include "estancia/labelers/network_labeler.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "estancia/core/fail.hpp"
#include "estancia/labelers/area_resize.hpp"

namespace estancia {
namespace {

/// `share` of `size`, at least one pixel, in the middle.
cv::Range centered(int size, double length) {
  const int kept = std::clamp(static_cast<int>(std::lround(length)), 1, size);
  const int start = (size - kept) / 2;
  return {start, start + kept};
}

cv::Mat centerOf(const cv::Mat& image, const Preprocessing& how) {
  const double side = how.crop * std::min(image.rows, image.cols);
  const bool square = how.region == Preprocessing::Region::square;
  return image(centered(image.rows, square ? side : how.crop * image.rows),
               centered(image.cols, square ? side : how.crop * image.cols));
}

int interpolation(const cv::Mat& region, const Preprocessing& how) {
  switch (how.resize) {
    case Preprocessing::Resize::linear:
      return cv::INTER_LINEAR;
    case Preprocessing::Resize::cubic:
      return cv::INTER_CUBIC;
    case Preprocessing::Resize::area:
      break;
  }
  return region.cols > how.width || region.rows > how.height ? cv::INTER_AREA : cv::INTER_LINEAR;
}

cv::Mat toInputSize(const cv::Mat& region, const Preprocessing& how) {
  const cv::Size size(how.width, how.height);
  const int method = interpolation(region, how);
  // OpenCV is quick where each pixel is the mean of a block.
  const bool blocks = region.cols % size.width == 0 && region.rows % size.height == 0;
  if (method == cv::INTER_AREA && !blocks && region.type() == CV_8UC3 && size.width <= region.cols &&
      size.height <= region.rows)
    return resizeByArea(region, size);
  cv::Mat resized;
  cv::resize(region, resized, size, 0, 0, method);
  return resized;
}

/// 8 bits, three channels in the network's order.
cv::Mat colors(const cv::Mat& image, Preprocessing::Color order) {
  cv::Mat bytes = image;
  if (image.depth() == CV_16U) image.convertTo(bytes, CV_8U, 1 / 257.0);  // 65535 / 257 = 255
  const bool rgb = order == Preprocessing::Color::rgb;
  cv::Mat result;
  switch (bytes.channels()) {
    case 1:
      cv::cvtColor(bytes, result, cv::COLOR_GRAY2BGR);
      return result;
    case 4:
      cv::cvtColor(bytes, result, rgb ? cv::COLOR_BGRA2RGB : cv::COLOR_BGRA2BGR);
      return result;
    default:
      break;
  }
  if (!rgb) return bytes;
  cv::cvtColor(bytes, result, cv::COLOR_BGR2RGB);
  return result;
}

}  // namespace

cv::Mat preprocess(const cv::Mat& image, const Preprocessing& how) {
  if (image.empty() || image.dims != 2)
    throw Error(ErrorCode::invalidInput, "an empty image cannot be labeled");
  const int channels = image.channels();
  if ((image.depth() != CV_8U && image.depth() != CV_16U) ||
      (channels != 1 && channels != 3 && channels != 4))
    fail(ErrorCode::invalidInput,
         "an image of {} channels of type {} cannot be labeled; give gray, BGR or BGRA of 8 or 16 bits",
         channels, cv::depthToString(image.depth()));
  const cv::Mat region = centerOf(image, how);
  const cv::Mat resized = colors(toInputSize(region, how), how.color);

  cv::Mat blob({1, 3, how.height, how.width}, CV_32F);
  std::array<cv::Mat, 3> planes;
  cv::split(resized, planes);
  for (int c = 0; c < 3; ++c) {
    const auto i = static_cast<std::size_t>(c);
    cv::Mat plane(how.height, how.width, CV_32F, blob.ptr<float>(0, c));
    planes[i].convertTo(plane, CV_32F, how.scale[i], -how.mean[i] * how.scale[i]);
  }
  return blob;
}

}  // namespace estancia
