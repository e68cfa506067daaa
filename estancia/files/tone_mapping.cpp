// SPDX-License-Identifier: Apache-2.0
#include "estancia/files/image_decoding.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>

namespace estancia::io {
namespace {

constexpr double middleGray = 0.18;
constexpr float maxRadiance = 65504;  // the largest half-precision number
constexpr float shoulder = 0.6F;      // linear light above this is rolled off

/// The exponential of the mean of log luminance over the sphere, rows weighted by the solid angle of their
/// pixels (Reinhard et al. 2002, Eq. 1). Pixels without light do not count; 0 when there is no light at all.
double logAverage(const cv::Mat& linear) {
  double sum = 0, weights = 0;
  for (int row = 0; row < linear.rows; ++row) {
    const double weight = std::sin(std::numbers::pi * (row + 0.5) / linear.rows);
    for (int column = 0; column < linear.cols; ++column) {
      const auto& p = linear.at<cv::Vec3f>(row, column);
      const float luminance = 0.0722F * p[0] + 0.7152F * p[1] + 0.2126F * p[2];
      if (!(luminance > 0) || !std::isfinite(luminance)) continue;
      sum += weight * std::log(luminance);
      weights += weight;
    }
  }
  return weights > 0 ? std::exp(sum / weights) : 0;
}

/// The lower median, by channel, of undamaged neighbors of (row, column); columns wrap. False without any.
bool medianOfNeighbors(const cv::Mat& linear, const cv::Mat& damaged, int row, int column,
                       cv::Vec3f& median) {
  std::array<std::array<float, 8>, 3> values;
  std::size_t count = 0;
  for (int r = std::max(row - 1, 0); r <= std::min(row + 1, linear.rows - 1); ++r) {
    for (int step = -1; step <= 1; ++step) {
      const int c = (column + step + linear.cols) % linear.cols;
      if (damaged.at<uchar>(r, c) != 0) continue;
      for (std::size_t k = 0; k < 3; ++k) values[k][count] = linear.at<cv::Vec3f>(r, c)[static_cast<int>(k)];
      ++count;
    }
  }
  if (count == 0) return false;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto middle = values[k].begin() + static_cast<std::ptrdiff_t>((count - 1) / 2);
    std::nth_element(values[k].begin(), middle, values[k].begin() + static_cast<std::ptrdiff_t>(count));
    median[static_cast<int>(k)] = *middle;
  }
  return true;
}

/// Resampled panoramas ring around lamps and the sun: pixels there are negative, infinite or NaN, and would
/// show as black dots. Such pixels are filled from their undamaged neighbors, from the rim inwards.
void repairRinging(cv::Mat& linear, double average) {
  constexpr int maxDepth = 8;  // [pixels]; the sun is about 6 wide
  const auto black = static_cast<float>(1e-3 * average);
  cv::Mat damaged(linear.size(), CV_8U);
  for (int row = 0; row < linear.rows; ++row) {
    for (int column = 0; column < linear.cols; ++column) {
      // Deep yellow lacks blue; a pixel with light in at most one channel is damaged.
      auto& p = linear.at<cv::Vec3f>(row, column);
      const float dark = std::max(black, 1e-3F * std::max({p[0], p[1], p[2]}));
      int lit = 0;
      for (int c = 0; c < 3; ++c) {
        if (p[c] > dark && p[c] <= maxRadiance) ++lit;
        p[c] = p[c] > 0 ? std::min(p[c], maxRadiance) : 0;  // NaN becomes 0
      }
      damaged.at<uchar>(row, column) = lit >= 2 ? 0 : 1;
    }
  }
  for (int depth = 0; depth < maxDepth && cv::countNonZero(damaged) > 0; ++depth) {
    const cv::Mat before = damaged.clone(), source = linear.clone();
    for (int row = 0; row < linear.rows; ++row)
      for (int column = 0; column < linear.cols; ++column)
        if (before.at<uchar>(row, column) != 0 &&
            medianOfNeighbors(source, before, row, column, linear.at<cv::Vec3f>(row, column)))
          damaged.at<uchar>(row, column) = 0;
  }
}

float toSrgb(float linear) {
  return linear <= 0.0031308F ? 12.92F * linear : 1.055F * std::pow(linear, 1 / 2.4F) - 0.055F;
}

float toLinear(float srgb) {
  return srgb <= 0.04045F ? srgb / 12.92F : std::pow((srgb + 0.055F) / 1.055F, 2.4F);
}

/// Identity up to the shoulder, then an exponential approach to 1 with the same slope where they meet.
float rollOff(float x) {
  return x <= shoulder ? x : 1 - (1 - shoulder) * std::exp(-(x - shoulder) / (1 - shoulder));
}

}  // namespace

cv::Mat toneMap(cv::Mat panorama, double exposure) {
  auto gain = static_cast<float>(std::exp2(exposure));
  const bool radiance = panorama.depth() == CV_32F;
  if (radiance) {
    const double average = logAverage(panorama);
    repairRinging(panorama, average);
    if (average > 0) gain *= static_cast<float>(middleGray / average);
  } else {
    panorama.convertTo(panorama, CV_32F, 1 / 255.0);
  }
  panorama.forEach<cv::Vec3f>([&](cv::Vec3f& p, const int*) {
    for (int c = 0; c < 3; ++c)
      p[c] = toSrgb(radiance ? rollOff(gain * p[c]) : std::min(gain * toLinear(p[c]), 1.F));
  });
  cv::Mat image;
  panorama.convertTo(image, CV_8U, 255);
  return image;
}

}  // namespace estancia::io
