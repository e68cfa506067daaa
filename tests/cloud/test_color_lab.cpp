// SPDX-License-Identifier: Apache-2.0
#include "estancia/cloud/color_lab.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

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

}  // namespace
}  // namespace estancia
