// Descriptors of images: GIST as its authors compute it, and PHOG as in the paper.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "describe/made_up_sequence.hpp"
#include "estancia/describe/gist.hpp"
#include "estancia/describe/phog.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using std::numbers::pi;
using test::busyImage;
using test::FailsWith;

cv::Mat mirrored(const cv::Mat& m, int border) {
  cv::Mat out;
  cv::copyMakeBorder(m, out, border, border, border, border, cv::BORDER_REFLECT);
  return out;
}

/// `m` (CV_64F or CV_64FC2) through a transfer function of frequencies in cycles an image; complex.
template <class Transfer>
cv::Mat filtered(const cv::Mat& m, Transfer transfer) {
  cv::Mat spectrum;
  cv::dft(m, spectrum, cv::DFT_COMPLEX_OUTPUT);
  const int n = m.rows;
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x)
      spectrum.at<cv::Vec2d>(y, x) *= transfer(x < (n + 1) / 2 ? x : x - n, y < (n + 1) / 2 ? y : y - n);
  cv::dft(spectrum, spectrum, cv::DFT_INVERSE | cv::DFT_SCALE);
  return spectrum;
}

cv::Mat realPart(const cv::Mat& m) {
  cv::Mat real;
  cv::extractChannel(m, real, 0);
  return real;
}

/// The authors' program for a square of 256 pixels, filter by filter on all pixels, in double precision.
std::vector<double> slowGist(const cv::Mat& square) {
  cv::Mat image(256, 256, CV_64F);
  for (int y = 0; y < 256; ++y)
    for (int x = 0; x < 256; ++x) {
      const auto p = square.at<cv::Vec3b>(y, x);
      image.at<double>(y, x) = (p[0] + p[1] + p[2]) / 3.0;
    }
  double least = 0, most = 0;
  cv::minMaxLoc(image, &least, &most);
  image = (image - least) * (255 / (most - least));

  cv::Mat logarithm;
  cv::log(image + 1, logarithm);
  logarithm = mirrored(logarithm, 5);
  const double s1 = 4 / std::sqrt(std::log(2));
  const auto low = [&](int fx, int fy) { return std::exp(-(fx * fx + fy * fy) / (s1 * s1)); };
  const cv::Mat detail = logarithm - realPart(filtered(logarithm, low));
  cv::Mat deviation;
  cv::sqrt(cv::abs(realPart(filtered(detail.mul(detail), low))), deviation);
  const cv::Mat equal = detail / (0.2 + deviation);
  const cv::Mat bordered = mirrored(equal(cv::Rect(5, 5, 256, 256)).clone(), 32);

  std::vector<double> means;
  for (int scale = 0; scale < 4; ++scale)
    for (int orientation = 0; orientation < 8; ++orientation) {
      const cv::Mat answer = filtered(bordered, [&](int fx, int fy) {
        double angle = std::atan2(fy, fx) + pi / 8 * orientation;
        if (angle > pi) angle -= 2 * pi;
        const double f = std::hypot(fx, fy) / 320 / (0.3 / std::pow(1.85, scale));
        return std::exp(-10 * 0.35 * (f - 1) * (f - 1) - 2 * pi * angle * angle);
      });
      for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 4; ++column) {
          double sum = 0;
          for (int y = 0; y < 64; ++y)
            for (int x = 0; x < 64; ++x)
              sum += cv::norm(answer.at<cv::Vec2d>(32 + row * 64 + y, 32 + column * 64 + x));
          means.push_back(sum / (64 * 64));
        }
    }
  return means;
}

/// |a - b| / |b|.
double difference(const std::vector<double>& a, const std::vector<double>& b) {
  return cv::norm(a, b) / cv::norm(b);
}

TEST(Gist, IsWithinThreePerMilleOfTheAuthorsProgram) {
  cv::Mat noise(256, 256, CV_8UC3), step(256, 256, CV_8UC3, cv::Scalar::all(20));
  cv::RNG(3).fill(noise, cv::RNG::UNIFORM, 0, 256);
  step.colRange(150, 256).setTo(cv::Scalar::all(220));
  for (const cv::Mat& image : {busyImage({256, 256}, 1), step, noise}) {
    const std::vector<float> ours = gist(image);
    const std::vector<double> theirs = slowGist(image);
    ASSERT_EQ(ours.size(), 512U);
    EXPECT_LT(difference({ours.begin(), ours.end()}, theirs), 3e-3);
    const double largest = *std::max_element(theirs.begin(), theirs.end());
    for (std::size_t i = 0; i < 512; ++i) EXPECT_NEAR(ours[i], theirs[i], 0.01 * largest) << i;
  }
}

TEST(Gist, IsZeroWithoutContrast) {
  for (const int value : {0, 77, 255}) {
    const auto v = gist(cv::Mat(240, 320, CV_8UC3, cv::Scalar::all(value)));
    EXPECT_EQ(v, std::vector<float>(512, 0.0F));
  }
}

TEST(Gist, TakesImagesOfAnySizeGrayOrColor) {
  for (const cv::Size size : {cv::Size(1, 1), {1, 9000}, {9000, 1}, {2, 2}, {3, 5}, {1200, 900}}) {
    const auto v = gist(busyImage(size, 8));
    ASSERT_EQ(v.size(), 512U);
    for (const float x : v) ASSERT_TRUE(std::isfinite(x) && x >= 0) << size;
  }
  const cv::Mat gray = busyImage({200, 100}, 9, 1);
  cv::Mat color;
  cv::cvtColor(gray, color, cv::COLOR_GRAY2BGR);
  EXPECT_LT(cv::norm(gist(gray), gist(color)), 1e-5 * cv::norm(gist(gray)));
}

TEST(Gist, RefusesWhatIsNoImage) {
  EXPECT_THAT([] { gist({}); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([] { gist(cv::Mat(9, 9, CV_32F)); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([] { Gist().describe({}); }, FailsWith(ErrorCode::invalidInput));
}

TEST(Gist, NamesItsNumbers) {
  const DescriptorPart part = Gist().parts().front();
  EXPECT_EQ(part.size(), 512U);
  EXPECT_EQ(part.columns[17], "gist 0.1.1");
  EXPECT_EQ(part.kind, PartKind::energies);
}

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
