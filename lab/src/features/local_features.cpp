// SPDX-License-Identifier: Apache-2.0
#include "features/local_features.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "estancia/core/fail.hpp"

namespace estancia::experiments {
namespace {

constexpr int most = 500;  // keypoints

/// The bits of each byte, the lowest first.
cv::Mat unpacked(const cv::Mat& bytes) {
  cv::Mat bits(bytes.rows, 8 * bytes.cols, CV_32F);
  for (int row = 0; row < bits.rows; ++row)
    for (int bit = 0; bit < bits.cols; ++bit)
      bits.at<float>(row, bit) = static_cast<float>(bytes.at<uchar>(row, bit / 8) >> (bit % 8) & 1);
  return bits;
}

void takeRootsOfShares(cv::Mat& rows) {
  for (int row = 0; row < rows.rows; ++row) {
    cv::Mat values = rows.row(row);
    const double sum = cv::sum(values)[0];
    if (sum > 0) values /= sum;
    cv::sqrt(values, values);
  }
}

}  // namespace

std::size_t dimensionsOf(LocalFeature feature) {
  return feature == LocalFeature::orb ? 256 : 128;
}

cv::Mat localFeatures(LocalFeature feature, const cv::Mat& image) {
  if (image.empty() || image.type() != CV_8UC3)
    fail(ErrorCode::invalidInput, "local features need a BGR image of 8 bits; convert it first");
  cv::Mat gray, rows;
  cv::cvtColor(image, gray, cv::COLOR_BGR2GRAY);
  std::vector<cv::KeyPoint> keypoints;
  if (feature == LocalFeature::orb) {
    cv::ORB::create(most)->detectAndCompute(gray, {}, keypoints, rows);
    return rows.empty() ? cv::Mat(0, static_cast<int>(dimensionsOf(feature)), CV_32F) : unpacked(rows);
  }
  cv::SIFT::create(most)->detectAndCompute(gray, {}, keypoints, rows);
  if (rows.empty()) return cv::Mat(0, static_cast<int>(dimensionsOf(feature)), CV_32F);
  rows = rows.rowRange(0, std::min(rows.rows, most)).clone();
  takeRootsOfShares(rows);
  return rows;
}

}  // namespace estancia::experiments
