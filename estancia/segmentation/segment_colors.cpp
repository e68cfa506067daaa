// SPDX-License-Identifier: Apache-2.0
#include "estancia/segmentation/segment_colors.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace estancia {
namespace {

constexpr float lightness = 0.25F;  // weight of lightness to chroma
constexpr float dark = 20;          // lightness below which chroma is noise

cv::Mat toLab(const cv::Mat& image) {
  cv::Mat lab;
  // OpenCV makes its tables at the first conversion, without a lock: two threads would both, and leak one's.
  static const bool tablesAreMade [[maybe_unused]] = [] {
    cv::Mat pixel;
    cv::cvtColor(cv::Mat3b(1, 1, cv::Vec3b()), pixel, cv::COLOR_BGR2Lab);
    return true;
  }();
  cv::cvtColor(image, lab, cv::COLOR_BGR2Lab);
  return lab;
}

}  // namespace

SegmentColors segmentColors(const cv::Mat& image, const cv::Size& size) {
  if (image.empty()) return {};
  cv::Mat fitting = image, blurred;
  if (image.size() != size) cv::resize(image, fitting, size, 0, 0, cv::INTER_AREA);
  cv::blur(fitting, blurred, {3, 3});
  const cv::Mat lab = toLab(blurred);
  SegmentColors features(size);
  std::transform(lab.begin<cv::Vec3b>(), lab.end<cv::Vec3b>(), features.begin(), [](const cv::Vec3b& c) {
    const float l = static_cast<float>(c[0]) / 2.55F, scale = 66 / std::max(l + 16, dark + 16);
    return cv::Vec3f(lightness * l, scale * (static_cast<float>(c[1]) - 128),
                     scale * (static_cast<float>(c[2]) - 128));
  });
  return features;
}

}  // namespace estancia
