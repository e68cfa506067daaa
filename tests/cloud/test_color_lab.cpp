// SPDX-License-Identifier: Apache-2.0
#include "estancia/cloud/color_lab.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>

#include "estancia/cloud/neighbors.hpp"

namespace estancia {
namespace {

TEST(Cielab, IsOpencvsWithinItsTables) {
  for (int i = 0; i < 4096; ++i) {
    const cv::Vec3b bgr(static_cast<uchar>(17 * (i % 16)), static_cast<uchar>(17 * (i / 16 % 16)),
                        static_cast<uchar>(17 * (i / 256)));
    cv::Mat theirs;
    cv::cvtColor(cv::Mat(1, 1, CV_32FC3, cv::Scalar(bgr[0] / 255.0, bgr[1] / 255.0, bgr[2] / 255.0)), theirs,
                 cv::COLOR_BGR2Lab);
    EXPECT_LT(cv::norm(labOf(bgr) - theirs.at<cv::Vec3f>(0)), 1.5) << bgr;
  }
  EXPECT_LT(cv::norm(labOf(cv::Vec3b(255, 255, 255)) - cv::Vec3f(100, 0, 0)), 0.02);
  EXPECT_LT(cv::norm(labOf(cv::Vec3b(0, 0, 0))), 1e-3);
  EXPECT_LT(cv::norm(labOf(cv::Vec3b(0, 0, 255)) - cv::Vec3f(53.24F, 80.09F, 67.20F)), 0.1);
}

/// A grid with a texture, and noise on each channel.
double noiseOf(double sigma, int stripe) {
  std::mt19937 random(1);
  std::normal_distribution<float> noise(0, static_cast<float>(sigma));
  std::vector<cv::Point3f> points;
  std::vector<cv::Vec3f> lab;
  for (int i = 0; i < 10000; ++i) {
    points.emplace_back(static_cast<float>(i % 100) + 0.1F * noise(random), static_cast<float>(i / 100), 1.F);
    const float level = stripe > 0 && i % 100 / stripe % 2 == 0 ? 80.F : 40.F;
    lab.push_back(cv::Vec3f(level, 0, 20) + cv::Vec3f(noise(random), noise(random), noise(random)));
  }
  return estimateColorNoise(Neighbors(points), lab);
}

TEST(ColorNoise, IsThatOfAChannelWhateverTheTexture) {
  for (const double sigma : {0.5, 2.0, 8.0}) {
    EXPECT_NEAR(noiseOf(sigma, 0), sigma, 0.1 * sigma);
    EXPECT_NEAR(noiseOf(sigma, 10), sigma, 0.25 * sigma);
  }
}

TEST(ColorNoise, IsAtLeastThatOfRounding) {
  EXPECT_NEAR(noiseOf(0, 0), 0.113, 0.001);
  EXPECT_NEAR(estimateColorNoise(Neighbors(std::vector<cv::Point3f>{{1, 2, 3}}), {{50, 0, 0}}), 0.113, 0.001);
}

}  // namespace
}  // namespace estancia
