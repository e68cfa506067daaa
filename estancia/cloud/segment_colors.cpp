// SPDX-License-Identifier: Apache-2.0
#include "estancia/cloud/segment_colors.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace estancia {
namespace {

constexpr float kLightness = 0.25F;  // weight of lightness to chroma
constexpr float kDark = 20;          // lightness below which chroma is noise

}  // namespace

SegmentColors segmentColors(const cv::Mat& image, const cv::Size& size) {
  if (image.empty()) return {};
  cv::Mat fitting = image, blurred, lab;
  if (image.size() != size) cv::resize(image, fitting, size, 0, 0, cv::INTER_AREA);
  cv::blur(fitting, blurred, {3, 3});
  cv::cvtColor(blurred, lab, cv::COLOR_BGR2Lab);
  SegmentColors features(size);
  std::transform(lab.begin<cv::Vec3b>(), lab.end<cv::Vec3b>(), features.begin(), [](const cv::Vec3b& c) {
    const float l = static_cast<float>(c[0]) / 2.55F, scale = 66 / std::max(l + 16, kDark + 16);
    return cv::Vec3f(kLightness * l, scale * (static_cast<float>(c[1]) - 128),
                     scale * (static_cast<float>(c[2]) - 128));
  });
  return features;
}

}  // namespace estancia
