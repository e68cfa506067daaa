// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "describe/made_up_sequence.hpp"
#include "estancia/describe/gist.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using test::busyImage;
using test::FailsWith;

using std::numbers::pi;

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

double length(const std::vector<double>& v) {
  double sum = 0;
  for (const double x : v) sum += x * x;
  return std::sqrt(sum);
}

double length(const std::vector<float>& v) {
  return length(std::vector<double>(v.begin(), v.end()));
}

/// |a - b| / |b|.
template <class A, class B>
double difference(const std::vector<A>& a, const std::vector<B>& b) {
  std::vector<double> d;
  for (std::size_t i = 0; i < a.size(); ++i)
    d.push_back(static_cast<double>(a[i]) - static_cast<double>(b[i]));
  return length(d) / length(b);
}

TEST(Gist, IsWithinThreePerMilleOfTheAuthorsProgram) {
  cv::Mat noise(256, 256, CV_8UC3), step(256, 256, CV_8UC3, cv::Scalar::all(20));
  cv::RNG(3).fill(noise, cv::RNG::UNIFORM, 0, 256);
  step.colRange(150, 256).setTo(cv::Scalar::all(220));
  for (const cv::Mat& image : {busyImage({256, 256}, 1), step, noise}) {
    const std::vector<float> ours = gist(image);
    const std::vector<double> theirs = slowGist(image);
    ASSERT_EQ(ours.size(), 512U);
    EXPECT_LT(difference(ours, theirs), 3e-3);
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
  EXPECT_LT(difference(gist(gray), gist(color)), 1e-5);
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

}  // namespace
}  // namespace estancia
