// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "describe/made_up_sequence.hpp"
#include "estancia/describe/phog.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using test::busyImage;
using test::FailsWith;

using std::numbers::pi;

double sumOfRange(const std::vector<float>& v, std::size_t begin = 0, std::size_t end = std::string::npos) {
  const auto at = [&](std::size_t i) {
    return v.begin() + static_cast<std::ptrdiff_t>(std::min(i, v.size()));
  };
  return std::accumulate(at(begin), at(end), 0.0);
}

/// Sobel's 3 × 3 mask, pixels outside being those at the edge.
cv::Vec2d sobel(const cv::Mat& gray, int y, int x) {
  const auto at = [&](int dy, int dx) {
    return static_cast<double>(
        gray.at<uchar>(std::clamp(y + dy, 0, gray.rows - 1), std::clamp(x + dx, 0, gray.cols - 1)));
  };
  return {at(-1, 1) + 2 * at(0, 1) + at(1, 1) - at(-1, -1) - 2 * at(0, -1) - at(1, -1),
          at(1, -1) + 2 * at(1, 0) + at(1, 1) - at(-1, -1) - 2 * at(-1, 0) - at(-1, 1)};
}

/// Cell by cell, level by level, every pixel of each looked at again. OpenCV's Canny finds the edges.
std::vector<double> slowPhog(const cv::Mat& bgr, int bins, int levels, int range) {
  cv::Mat gray, smooth;
  cv::cvtColor(bgr, gray, cv::COLOR_BGR2GRAY);
  cv::GaussianBlur(gray, smooth, {9, 9}, std::sqrt(2), 0, cv::BORDER_REPLICATE);
  cv::Mat dx(gray.size(), CV_16S), dy(gray.size(), CV_16S), edges;
  std::vector<double> magnitudes;
  for (int y = 0; y < gray.rows; ++y)
    for (int x = 0; x < gray.cols; ++x) {
      const cv::Vec2d g = sobel(smooth, y, x);
      dx.at<short>(y, x) = static_cast<short>(g[0]);
      dy.at<short>(y, x) = static_cast<short>(g[1]);
      magnitudes.push_back(cv::norm(g));
    }
  std::sort(magnitudes.begin(), magnitudes.end());
  const double step = magnitudes.back() / 64,
               at70 = magnitudes[static_cast<std::size_t>(0.7 * static_cast<double>(magnitudes.size()))],
               high = (std::floor(at70 / step) + 1) * step;
  cv::Canny(dx, dy, edges, 0.4 * high, high, true);

  std::vector<double> all;
  for (int level = 0; level <= levels; ++level) {
    const int n = 1 << level;
    for (int row = 0; row < n; ++row)
      for (int column = 0; column < n; ++column) {
        std::vector<double> histogram(static_cast<std::size_t>(bins));
        for (int y = 0; y < gray.rows; ++y)
          for (int x = 0; x < gray.cols; ++x) {
            if (edges.at<uchar>(y, x) == 0 || y * n / gray.rows != row || x * n / gray.cols != column)
              continue;
            const cv::Vec2d g = sobel(gray, y, x);
            double degrees = std::atan2(g[1], g[0]) * 180 / pi;
            while (degrees < 0) degrees += range;
            while (degrees >= range) degrees -= range;
            histogram[static_cast<std::size_t>(degrees / range * bins)] += cv::norm(g);
          }
        all.insert(all.end(), histogram.begin(), histogram.end());
      }
  }
  const double sum = std::accumulate(all.begin(), all.end(), 0.0);
  for (double& v : all) v /= sum;
  return all;
}

TEST(Phog, IsThatOfThePaper) {
  for (const cv::Size size : {cv::Size(64, 48), {101, 77}, {33, 90}})
    for (const int range : {180, 360}) {
      const cv::Mat image = busyImage(size, 3);
      const std::vector<float> ours = phog(image, {.range = range});
      const std::vector<double> slow = slowPhog(image, 30, 2, range);
      ASSERT_EQ(ours.size(), 630U);
      ASSERT_EQ(slow.size(), 630U);
      // Directions on the very limit of two bins may fall to either side.
      double difference = 0;
      for (std::size_t i = 0; i < 630; ++i) difference += std::abs(ours[i] - slow[i]);
      EXPECT_LT(difference, 2e-3) << size << " " << range;
    }
}

TEST(Phog, EveryLevelHasTheSameEnergyAndCellsAddUp) {
  const auto v = phog(busyImage({123, 91}, 4), {.levels = 3});
  ASSERT_EQ(v.size(), 30U * 85);
  EXPECT_NEAR(sumOfRange(v), 1, 1e-5);
  for (const auto& [begin, end] : {std::pair{0U, 30U}, {30U, 150U}, {150U, 630U}, {630U, 2550U}})
    EXPECT_NEAR(sumOfRange(v, begin, end), 0.25, 1e-5);
  for (std::size_t bin = 0; bin < 30; ++bin)  // the upper left quarter
    EXPECT_NEAR(v[30 + bin], v[150 + bin] + v[180 + bin] + v[270 + bin] + v[300 + bin], 1e-6);
}

TEST(Phog, IsZeroWithoutEdges) {
  EXPECT_EQ(phog(cv::Mat(240, 320, CV_8UC3, cv::Scalar::all(99))), std::vector<float>(630, 0.0F));
  EXPECT_EQ(phog(cv::Mat(1, 1, CV_8UC3, cv::Scalar::all(99))), std::vector<float>(630, 0.0F));
}

TEST(Phog, TakesImagesOfAnySizeGrayOrColor) {
  for (const cv::Size size : {cv::Size(1, 500), {500, 1}, {1, 9000}, {2, 2}, {3, 3}, {5, 2}, {1200, 900}}) {
    const auto v = phog(busyImage(size, 5));
    ASSERT_EQ(v.size(), 630U);
    for (const float x : v) ASSERT_TRUE(std::isfinite(x) && x >= 0) << size;
    const double sum = sumOfRange(v);
    EXPECT_TRUE(sum == 0 || std::abs(sum - 1) < 1e-5) << size << sum;
  }
  const cv::Mat gray = busyImage({200, 100}, 9, 1);
  cv::Mat color;
  cv::cvtColor(gray, color, cv::COLOR_GRAY2BGR);
  EXPECT_EQ(phog(gray), phog(color));
}

TEST(Phog, DoesNotDependOnThreadsOfOpenCV) {
  const cv::Mat image = busyImage({640, 480}, 10);
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  const auto one = phog(image);
  cv::setNumThreads(4);
  EXPECT_EQ(phog(image), one);
  cv::setNumThreads(threads);
}

TEST(Phog, RefusesWhatItCannotDo) {
  EXPECT_THAT([] { phog({}); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([] { phog(cv::Mat(9, 9, CV_16UC3)); }, FailsWith(ErrorCode::invalidInput));
  const cv::Mat image = busyImage({20, 20}, 1);
  for (const PhogOptions& wrong : {PhogOptions{.bins = 0}, PhogOptions{.levels = 9}, PhogOptions{.range = 90},
                                   PhogOptions{.maxSide = 1}})
    EXPECT_THAT([&] { phog(image, wrong); }, FailsWith(ErrorCode::invalidOption));
  EXPECT_THAT([&] { Phog({.levels = -1}); }, FailsWith(ErrorCode::invalidOption));
}

TEST(Phog, NamesItsNumbers) {
  const DescriptorPart part = Phog().parts().front();
  EXPECT_EQ(part.size(), 630U);
  EXPECT_EQ(part.columns[30 * 6 + 2], "phog 2.1.2");
  EXPECT_EQ(part.kind, PartKind::histogram);
  EXPECT_NE(part.identity, Phog({.range = 180}).parts().front().identity);
}

}  // namespace
}  // namespace estancia
