// PNG files of our own, checked by OpenCV's codec.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/module_function.hpp"
#include "estancia/core/png.hpp"

#include <gtest/gtest.h>

#include <array>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "estancia/core/image_codecs.hpp"
#include "support/errors.hpp"
#include "support/images.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;

const cv::Size kMost{1000, 1000};

/// Any values, the same each time.
cv::Mat noise(cv::Size size, int type) {
  cv::Mat image(size, type);
  cv::RNG(7).fill(image, cv::RNG::UNIFORM, 0, 65536, true);
  return image;
}

bool isSame(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

TEST(Png, LosesNothing) {
  for (const int type : {CV_8U, CV_16U, CV_8UC3, CV_16UC3, CV_8UC4, CV_16UC4})
    for (const cv::Size size : {cv::Size(1, 1), cv::Size(37, 21), cv::Size(3, 300)}) {
      const cv::Mat image = noise(size, type);
      EXPECT_TRUE(isSame(cv::imdecode(toPng(image), cv::IMREAD_UNCHANGED), image)) << type << size;
      EXPECT_EQ(isSame(fromPng(toPng(image), size), image), image.channels() == 1) << type << size;
    }
}

TEST(Png, ReadsWhatOthersWrite) {
  for (const int type : {CV_8U, CV_16U}) {
    const cv::Mat image = noise({37, 21}, type);
    std::vector<unsigned char> png;
    cv::imencode(".png", image, png);
    EXPECT_TRUE(isSame(fromPng(png, kMost), image)) << type;
  }
}

TEST(Png, DecodesNothingLargerThanAllowed) {
  const auto png = toPng(noise({37, 21}, CV_8U));
  EXPECT_FALSE(fromPng(png, {37, 21}).empty());
  EXPECT_TRUE(fromPng(png, {36, 21}).empty());
  EXPECT_TRUE(fromPng(png, {37, 20}).empty());
  EXPECT_TRUE(fromPng(png, {0, 0}).empty());
  EXPECT_TRUE(fromPng(png, {-1, -1}).empty());
}

TEST(Png, NoticesDamage) {
  const auto whole = toPng(noise({37, 21}, CV_16U));
  for (std::size_t length = 0; length < whole.size(); length += 5)
    EXPECT_TRUE(fromPng({whole.data(), length}, kMost).empty()) << length;
  for (std::size_t at = 0; at < whole.size(); at += 3) {
    auto damaged = whole;
    damaged[at] ^= 0x41;
    EXPECT_TRUE(fromPng(damaged, kMost).empty()) << at;
  }
}

TEST(Png, RefusesOtherImages) {
  for (const cv::Mat& image : {cv::Mat(), cv::Mat(4, 4, CV_32F, cv::Scalar(1)),
                               cv::Mat(4, 4, CV_8UC2, cv::Scalar(1)), cv::Mat(4, 4, CV_16S, cv::Scalar(1))})
    EXPECT_THAT([&] { toPng(image); }, FailsWith(ErrorCode::invalidInput));
}

TEST(ModuleFunction, IsFoundOrItsModuleIsMissing) {
  EXPECT_THAT([] { getModuleFunction("libnowhere.so", "../lib", "f", "stars cannot be counted"); },
              FailsWith(ErrorCode::missingDependency));
  EXPECT_THAT([] { getModuleFunction("libm.so.6", "../lib", "nonesuch", "nothing works"); },
              FailsWith(ErrorCode::missingDependency));
  EXPECT_NE(getModuleFunction("libm.so.6", "../lib", "cos", "nothing works"), nullptr);
  EXPECT_THAT([] { getModuleFunction("libnowhere.so", "../lib", "f", "nothing works", "stars-dev"); },
              FailsWith(ErrorCode::missingDependency));
}

TEST(ImageCodecs, MayBeOpenedBySeveralThreadsAtOnce) {
  const cv::Mat gray(8, 8, CV_8UC3, cv::Scalar::all(90));
  std::array<double, 4> worst{};
  test::inThreads(4, [&](int t) {
    const auto jpeg = imageCodecs().encodeJpeg(gray, 95);
    worst[static_cast<std::size_t>(t)] =
        cv::norm(imageCodecs().decode(jpeg, DecodedAs::color), gray, cv::NORM_INF);
  });
  for (const double difference : worst) EXPECT_LE(difference, 1);
  EXPECT_TRUE(imageCodecs().decode(std::array<unsigned char, 3>{1, 2, 3}, DecodedAs::stored).empty());
}

}  // namespace
}  // namespace estancia
