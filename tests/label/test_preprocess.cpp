// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "estancia/label/network_labeler.hpp"
#include "support/errors.hpp"
#include "support/model_support.hpp"

namespace estancia {
namespace {

using test::FailsWith;

/// Input of `side` pixels, everything else as plain as can be: colors as they are, values as they are.
Preprocessing plain(int side, double crop = 1) {
  Preprocessing how;
  how.width = how.height = side;
  how.crop = crop;
  how.color = Preprocessing::Color::bgr;
  return how;
}

float at(const cv::Mat& blob, int channel, int y, int x) {
  return *(blob.ptr<float>(0, channel, y) + x);
}

/// A black image with a white rectangle.
cv::Mat withRectangle(cv::Size size, const cv::Rect& white) {
  cv::Mat image(size, CV_8UC3, cv::Scalar::all(0));
  image(white).setTo(cv::Scalar::all(255));
  return image;
}

TEST(Preprocess, GivesOnePlaneAChannel) {
  Preprocessing how = plain(7);
  how.height = 5;
  const cv::Mat blob = preprocess(cv::Mat(20, 30, CV_8UC3, cv::Scalar(10, 20, 30)), how);
  ASSERT_EQ(blob.dims, 4);
  EXPECT_EQ(std::vector<int>(blob.size.p, blob.size.p + 4), (std::vector<int>{1, 3, 5, 7}));
  EXPECT_EQ(blob.type(), CV_32F);
  for (int c = 0; c < 3; ++c) EXPECT_EQ(at(blob, c, 4, 6), 10 * (c + 1));
}

TEST(Preprocess, OrdersColorsMeansAndScalesAsTheNetworkDoes) {
  Preprocessing how = plain(2);
  how.color = Preprocessing::Color::rgb;
  how.mean = {30, 20, 0};
  how.scale = {1, 2, 0.5};
  const cv::Mat blob = preprocess(cv::Mat(2, 2, CV_8UC3, cv::Scalar(10, 21, 34)), how);
  EXPECT_EQ(at(blob, 0, 0, 0), 4) << "red first: (34 − 30) · 1";
  EXPECT_EQ(at(blob, 1, 0, 0), 2) << "(21 − 20) · 2";
  EXPECT_EQ(at(blob, 2, 0, 0), 5) << "(10 − 0) · 0.5";
}

TEST(Preprocess, CutsTheExactSquareOutOfTheMiddle) {
  // 87.5 % of 160 is 140: the square [50, 190) × [10, 150) of 240 × 160, here copied pixel by pixel
  const cv::Mat inside = withRectangle({240, 160}, {50, 10, 140, 140});
  EXPECT_EQ(cv::countNonZero(preprocess(inside, plain(140, 0.875)).reshape(1, 1) != 255), 0);
  cv::Mat corner(160, 240, CV_8UC3, cv::Scalar::all(0));
  corner.at<cv::Vec3b>(10, 50) = {1, 2, 3};
  corner.at<cv::Vec3b>(149, 189) = {4, 5, 6};
  const cv::Mat blob = preprocess(corner, plain(140, 0.875));
  EXPECT_EQ(at(blob, 1, 0, 0), 2);
  EXPECT_EQ(at(blob, 1, 139, 139), 5);
}

TEST(Preprocess, KeepsACenteredSquareCenteredAndSquare) {
  for (const cv::Size size : {cv::Size(320, 240), cv::Size(240, 320), cv::Size(641, 481)}) {
    const cv::Mat image = withRectangle(size, {size.width / 2 - 40, size.height / 2 - 40, 80, 80});
    const cv::Mat blob = preprocess(image, plain(96, 0.875));
    const cv::Mat plane(96, 96, CV_32F, const_cast<float*>(blob.ptr<float>(0, 0)));
    const auto moments = cv::moments(plane);
    EXPECT_NEAR(moments.m10 / moments.m00, 47.5, 0.5) << size;
    EXPECT_NEAR(moments.m01 / moments.m00, 47.5, 0.5) << size;
    EXPECT_NEAR(moments.mu20 / moments.mu02, 1, 0.02) << size;
  }
}

TEST(Preprocess, StretchesTheWholeImageWhenAsked) {
  Preprocessing how = plain(100);
  how.region = Preprocessing::Region::stretch;
  // the right quarter of a wide image is the right quarter of the input, too
  const cv::Mat blob = preprocess(withRectangle({400, 100}, {300, 0, 100, 100}), how);
  EXPECT_EQ(at(blob, 0, 50, 74), 0);
  EXPECT_EQ(at(blob, 0, 50, 75), 255);
  EXPECT_EQ(at(blob, 0, 50, 99), 255);
}

TEST(Preprocess, AveragesAllPixelsWhenItShrinks) {
  cv::Mat checkered(64, 64, CV_8UC3);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x)
      checkered.at<cv::Vec3b>(y, x) = (x + y) % 2 == 0 ? cv::Vec3b(0, 0, 0) : cv::Vec3b(200, 200, 200);
  EXPECT_EQ(at(preprocess(checkered, plain(8)), 0, 3, 3), 100);
}

TEST(Preprocess, TakesGraySixteenBitsAndAlpha) {
  const cv::Mat expected = preprocess(cv::Mat(9, 9, CV_8UC3, cv::Scalar::all(200)), plain(4));
  const auto same = [&](const cv::Mat& image) {
    return cv::norm(preprocess(image, plain(4)), expected, cv::NORM_INF) == 0;
  };
  EXPECT_TRUE(same(cv::Mat(9, 9, CV_8UC1, cv::Scalar(200))));
  EXPECT_TRUE(same(cv::Mat(9, 9, CV_8UC4, cv::Scalar(200, 200, 200, 3))));
  EXPECT_TRUE(same(cv::Mat(9, 9, CV_16UC1, cv::Scalar(200 * 257))));
  EXPECT_TRUE(same(cv::Mat(9, 9, CV_16UC3, cv::Scalar::all(200 * 257))));
  Preprocessing rgb = plain(4);
  rgb.color = Preprocessing::Color::rgb;
  EXPECT_EQ(at(preprocess(cv::Mat(9, 9, CV_8UC4, cv::Scalar(1, 2, 3, 4)), rgb), 0, 0, 0), 3) << "BGRA";
}

TEST(Preprocess, TakesAnySize) {
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(1, 500), cv::Size(3000, 2)}) {
    const cv::Mat blob = preprocess(cv::Mat(size, CV_8UC3, cv::Scalar(5, 6, 7)), plain(16, 0.875));
    EXPECT_EQ(at(blob, 2, 15, 15), 7) << size;
  }
}

TEST(Preprocess, RefusesWhatIsNoImage) {
  EXPECT_THAT([] { preprocess(cv::Mat(), plain(4)); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([] { preprocess(cv::Mat(4, 4, CV_32FC3), plain(4)); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([] { preprocess(cv::Mat(4, 4, CV_8UC2), plain(4)); }, FailsWith(ErrorCode::invalidInput));
}

}  // namespace
}  // namespace estancia
