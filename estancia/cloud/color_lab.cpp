// SPDX-License-Identifier: Apache-2.0
#include "estancia/cloud/color_lab.hpp"

#include <array>
#include <cmath>

namespace estancia {
namespace {

/// The cube root, continued by a line near black.
float f(float t) {
  constexpr float linearBelow = 216.F / 24389, slope = 841.F / 108, offset = 4.F / 29;
  return t > linearBelow ? std::cbrt(t) : slope * t + offset;
}

}  // namespace

cv::Vec3f labOf(const cv::Vec3b& bgr) {
  // Light of each of the 256 levels, in [0, 1].
  static const std::array<float, 256> level = [] {
    std::array<float, 256> table{};
    for (std::size_t i = 0; i < table.size(); ++i) {
      const double v = static_cast<double>(i) / 255;
      table[i] = static_cast<float>(v > 0.04045 ? std::pow((v + 0.055) / 1.055, 2.4) : v / 12.92);
    }
    return table;
  }();
  const float b = level[bgr[0]], g = level[bgr[1]], r = level[bgr[2]];
  const float x = f((0.412453F * r + 0.357580F * g + 0.180423F * b) / 0.950456F);
  const float y = f(0.212671F * r + 0.715160F * g + 0.072169F * b);
  const float z = f((0.019334F * r + 0.119193F * g + 0.950227F * b) / 1.088754F);
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

std::vector<cv::Vec3f> labOf(const std::vector<cv::Vec3b>& colors) {
  std::vector<cv::Vec3f> lab;
  lab.reserve(colors.size());
  for (const cv::Vec3b& color : colors) lab.push_back(labOf(color));
  return lab;
}

}  // namespace estancia
