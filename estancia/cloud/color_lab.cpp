// SPDX-License-Identifier: Apache-2.0
#include "estancia/cloud/color_lab.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>

#include "estancia/cloud/neighbors.hpp"

namespace estancia {
namespace {

/// Light of each of the 256 levels, in [0, 1].
const std::array<float, 256>& linearLevels() {
  static const std::array<float, 256> levels = [] {
    std::array<float, 256> table{};
    for (std::size_t i = 0; i < table.size(); ++i) {
      const double v = static_cast<double>(i) / 255;
      table[i] = static_cast<float>(v > 0.04045 ? std::pow((v + 0.055) / 1.055, 2.4) : v / 12.92);
    }
    return table;
  }();
  return levels;
}

/// The cube root, continued by a line near black.
float f(float t) {
  constexpr float linearBelow = 216.F / 24389, slope = 841.F / 108, offset = 4.F / 29;
  return t > linearBelow ? std::cbrt(t) : slope * t + offset;
}

}  // namespace

cv::Vec3f labOf(const cv::Vec3b& bgr) {
  const std::array<float, 256>& level = linearLevels();
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

double estimateColorNoise(const Neighbors& points, const std::vector<cv::Vec3f>& lab) {
  constexpr std::size_t samples = 2000;
  constexpr double rounding = 100.0 / 255 / (2 * std::numbers::sqrt3);  // rounding to one of 255 levels of L*
  constexpr double chi3 = 1.5382;                                       // median of the norm of three normals
  std::vector<double> differences;
  std::vector<Neighbor> buffer;
  const std::size_t step = std::max<std::size_t>(points.size() / samples, 1);
  for (std::size_t i = 0; i < points.size(); i += step) {
    const std::uint32_t self = points.order()[i];
    for (const Neighbor& n : points.nearest(points.place(i), 2, buffer)) {
      if (n.index == self) continue;
      differences.push_back(cv::norm(lab[self] - lab[n.index]));
      break;
    }
  }
  if (differences.empty()) return rounding;
  const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
  std::nth_element(differences.begin(), middle, differences.end());
  return std::max(*middle / (std::numbers::sqrt2 * chi3), rounding);
}

}  // namespace estancia
