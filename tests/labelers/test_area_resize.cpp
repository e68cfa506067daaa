// SPDX-License-Identifier: Apache-2.0
#include "estancia/labelers/area_resize.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

namespace estancia {
namespace {

cv::Mat noise(int width, int height) {
  cv::Mat image(height, width, CV_8UC3);
  cv::RNG(static_cast<std::uint64_t>(width * height)).fill(image, cv::RNG::UNIFORM, 0, 256);
  return image;
}

/// The largest difference to OpenCV's, and that hardly any value has it.
void expectAsOpencv(const cv::Mat& image, cv::Size size) {
  cv::Mat expected, difference;
  cv::resize(image, expected, size, 0, 0, cv::INTER_AREA);
  const cv::Mat resized = resizeByArea(image, size);
  ASSERT_EQ(resized.size(), size);
  cv::absdiff(resized, expected, difference);
  EXPECT_LE(cv::norm(difference, cv::NORM_INF), 1) << image.size() << " → " << size;
  EXPECT_LE(cv::norm(difference, cv::NORM_L1), 1 + 1e-3 * static_cast<double>(expected.total() * 3))
      << image.size() << " → " << size;
}

TEST(AreaResize, IsWhatOpencvComputes) {
  expectAsOpencv(noise(210, 210), {128, 128});
  expectAsOpencv(noise(420, 420), {299, 299});
  expectAsOpencv(noise(640, 480), {224, 224});
  expectAsOpencv(noise(1000, 31), {7, 30});
  expectAsOpencv(noise(33, 57), {32, 5});
  expectAsOpencv(noise(40, 30), {3, 29});
  expectAsOpencv(noise(3, 2), {2, 1});
  for (int from = 11; from < 60; ++from) expectAsOpencv(noise(from, 71 - from), {11, 11});
}

TEST(AreaResize, TakesPartsOfImages) {
  expectAsOpencv(noise(100, 90)(cv::Rect(13, 7, 61, 53)), {40, 40});
}

TEST(AreaResize, KeepsWhatIsNotShrunkAndWhatIsPlain) {
  const cv::Mat image = noise(17, 13);
  EXPECT_EQ(cv::norm(resizeByArea(image, image.size()), image, cv::NORM_INF), 0);
  const cv::Mat white(50, 70, CV_8UC3, cv::Scalar::all(255));
  EXPECT_EQ(cv::norm(resizeByArea(white, {33, 29}), cv::Mat(29, 33, CV_8UC3, cv::Scalar::all(255))), 0);
}

TEST(AreaResize, RefusesOtherTypesAndEnlarging) {
  EXPECT_THROW(resizeByArea(cv::Mat(9, 9, CV_8U), {4, 4}), cv::Exception);
  EXPECT_THROW(resizeByArea(noise(9, 9), {10, 4}), cv::Exception);
  EXPECT_THROW(resizeByArea(noise(9, 9), {0, 4}), cv::Exception);
}

}  // namespace
}  // namespace estancia
