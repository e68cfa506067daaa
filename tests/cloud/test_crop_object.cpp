// Crops of objects: from an image, or rendered from points.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/cloud/crop_object.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "support/clouds.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;

using Background = CropOptions::Background;
const cv::Vec3b kGray(128, 128, 128);

/// 40 × 30 pixels, each of which encodes its position.
cv::Mat places() {
  cv::Mat image(30, 40, CV_8UC3);
  for (int v = 0; v < 30; ++v)
    for (int u = 0; u < 40; ++u)
      image.at<cv::Vec3b>(v, u) = cv::Vec3b(static_cast<uchar>(u), static_cast<uchar>(v), 200);
  return image;
}

CropOptions with(Background background, double margin = 0, double crop = 0.875) {
  CropOptions options;
  options.background = background;
  options.margin = margin;
  options.crop = crop;
  return options;
}

TEST(Crop, MiddleOfTheSquareHoldsTheThing) {
  const cv::Mat patch = cropObject(places(), {10, 12, 14, 6});
  ASSERT_EQ(patch.size(), cv::Size(16, 16));  // 14 / 0.875
  EXPECT_EQ(patch.at<cv::Vec3b>(0, 0), cv::Vec3b(9, 7, 200));
  EXPECT_EQ(patch.at<cv::Vec3b>(15, 15), cv::Vec3b(24, 22, 200));
  EXPECT_EQ(cropObject(places(), {10, 12, 4, 8}, {}, with(Background::kept, 0, 1)).size(), cv::Size(8, 8));
  EXPECT_EQ(cropObject(places(), {10, 12, 4, 8}, {}, with(Background::kept, 0.25, 1)).size(),
            cv::Size(12, 12));
}

TEST(Crop, GrayBeyondTheImage) {
  const cv::Mat patch = cropObject(places(), {0, 0, 14, 14});
  ASSERT_EQ(patch.size(), cv::Size(16, 16));
  EXPECT_EQ(patch.at<cv::Vec3b>(0, 5), kGray);
  EXPECT_EQ(patch.at<cv::Vec3b>(5, 0), kGray);
  EXPECT_EQ(patch.at<cv::Vec3b>(1, 1), cv::Vec3b(0, 0, 200));
}

TEST(Crop, BackgroundMayBePaintedOver) {
  cv::Mat mask = cv::Mat::zeros(30, 40, CV_8U);
  mask({10, 12, 2, 1}).setTo(255);
  mask.at<uchar>(25, 39) = 255;  // no part of the box
  const cv::Rect box(10, 12, 2, 2);
  const cv::Mat gray = cropObject(places(), box, mask, with(Background::gray, 0, 1));
  EXPECT_EQ(gray.at<cv::Vec3b>(0, 1), cv::Vec3b(11, 12, 200));
  EXPECT_EQ(gray.at<cv::Vec3b>(1, 1), kGray);
  const cv::Mat mean = cropObject(places(), box, mask, with(Background::mean, 1, 1));
  ASSERT_EQ(mean.size(), cv::Size(6, 6));
  EXPECT_EQ(mean.at<cv::Vec3b>(2, 3), cv::Vec3b(11, 12, 200));
  EXPECT_NEAR(mean.at<cv::Vec3b>(5, 5)[0], 10.5, 0.51);
  EXPECT_EQ(mean.at<cv::Vec3b>(5, 5)[1], 12);
  const cv::Mat kept = cropObject(places(), box, mask, with(Background::kept, 0, 1));
  EXPECT_EQ(kept.at<cv::Vec3b>(1, 1), cv::Vec3b(11, 13, 200));
}

TEST(Crop, RefusesWhatIsNoObjectInAnImage) {
  const cv::Mat image = places(), mask(30, 40, CV_8U, cv::Scalar(1));
  const auto problem = [&](const cv::Rect& box, const cv::Mat& m = {}, const CropOptions& options = {}) {
    return test::caught([&] { cropObject(image, box, m, options); });
  };
  constexpr int huge = std::numeric_limits<int>::max();
  for (const cv::Rect& box :
       {cv::Rect(0, 0, 0, 5), cv::Rect(-1, 0, 5, 5), cv::Rect(36, 0, 5, 5), cv::Rect(0, 28, 3, 3),
        cv::Rect(huge, 0, 5, 5), cv::Rect(1, 1, huge, huge), cv::Rect(0, 0, -4, 4)})
    EXPECT_THAT(problem(box), FailsWith(ErrorCode::invalidInput)) << box;
  const cv::Rect box(1, 1, 5, 5);
  EXPECT_FALSE(problem(box, mask, with(Background::mean)).code);
  EXPECT_THAT(problem(box, {}, with(Background::mean)), FailsWith(ErrorCode::invalidOption));
  EXPECT_THAT(problem(box, mask(cv::Rect(0, 0, 20, 20))), FailsWith(ErrorCode::mismatch));
  EXPECT_THAT(problem(box, cv::Mat(30, 40, CV_32S, cv::Scalar(1))), FailsWith(ErrorCode::mismatch));
  EXPECT_THAT(problem(box, cv::Mat::zeros(30, 40, CV_8U), with(Background::mean)),
              FailsWith(ErrorCode::invalidInput));
  for (const double margin : {-0.1, 4.1, std::nan("")})
    EXPECT_THAT(problem(box, {}, with(Background::kept, margin)), FailsWith(ErrorCode::invalidOption));
  for (const double crop : {0.0, 1.1, std::nan("")})
    EXPECT_THAT(problem(box, {}, with(Background::kept, 0, crop)), FailsWith(ErrorCode::invalidOption));
  const auto crop = [](const cv::Mat& bgr) { cropObject(bgr, {0, 0, 1, 1}); };
  EXPECT_THAT([&] { crop({}); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { crop(cv::Mat(9, 9, CV_8U)); }, FailsWith(ErrorCode::invalidInput));
  const cv::Mat wide = cv::Mat::zeros(1, 9000, CV_8UC3);
  const cv::Rect all(0, 0, 9000, 1);
  EXPECT_THAT([&] { cropObject(wide, all, {}, with(Background::kept, 4)); }, FailsWith(ErrorCode::tooLarge));
}

using test::cloudOf;

/// A board that stands upright and looks along `azimuth`: 24 cm wide, 12 cm high, its upper half red.
PointCloud board(double azimuth, double depth = 0) {
  PointCloud cloud;
  for (int i = -60; i < 60; ++i)
    for (int k = -30; k < 30; ++k) {
      const double along = 0.002 * i, up = 0.002 * k;
      cloud.points.emplace_back(static_cast<float>(-std::sin(azimuth) * along + depth * std::cos(azimuth)),
                                static_cast<float>(std::cos(azimuth) * along + depth * std::sin(azimuth)),
                                static_cast<float>(up));
      cloud.colors.push_back(k < 0 ? cv::Vec3b(0, 255, 0) : cv::Vec3b(0, 0, 255));
    }
  cloud.width = cloud.points.size();
  cloud.height = 1;
  return cloud;
}

int pixelsOf(const cv::Mat& image, const cv::Vec3b& color) {
  cv::Mat same;
  cv::inRange(image, color, color, same);
  return cv::countNonZero(same);
}

cv::Rect extentOf(const cv::Mat& image) {
  cv::Mat background;
  cv::inRange(image, kGray, kGray, background);
  return cv::boundingRect(background == 0);
}

TEST(RenderedObject, SeesTheBoardFromItsFaceAndUpright) {
  for (const int degrees : {0, 30, 75, 120, 285}) {
    const cv::Mat image = renderObject(board(degrees * CV_PI / 180), 200);
    ASSERT_EQ(image.size(), cv::Size(200, 200));
    const cv::Rect extent = extentOf(image);
    EXPECT_NEAR(extent.width, 175, 8) << degrees;
    EXPECT_NEAR(extent.height, 87, 8) << degrees;
    EXPECT_EQ(image.at<cv::Vec3b>(80, 100), cv::Vec3b(0, 0, 255)) << degrees;
    EXPECT_EQ(image.at<cv::Vec3b>(120, 100), cv::Vec3b(0, 255, 0)) << degrees;
    const cv::Rect inside(extent.x + 4, extent.y + 4, extent.width - 8, extent.height - 8);
    EXPECT_EQ(pixelsOf(image(inside), kGray), 0) << degrees << ": no holes between the points";
  }
}

TEST(RenderedObject, TheNearestIsInFront) {
  PointCloud near = board(0, 0.05), far = board(0, -0.05);
  near.colors.assign(near.points.size(), {0, 0, 255});
  far.colors.assign(far.points.size(), {255, 0, 0});
  for (auto& p : far.points) p = {p.x, p.y * 0.5F, p.z * 0.5F};  // hidden, seen from the front
  for (const bool nearFirst : {false, true}) {
    PointCloud both = nearFirst ? near : far;
    const PointCloud& second = nearFirst ? far : near;
    both.points.insert(both.points.end(), second.points.begin(), second.points.end());
    both.colors.insert(both.colors.end(), second.colors.begin(), second.colors.end());
    both.width = both.points.size();
    EXPECT_EQ(renderObject(both).at<cv::Vec3b>(149, 149), cv::Vec3b(0, 0, 255)) << nearFirst;
  }
}

TEST(RenderedObject, FewFarAndMissingPoints) {
  constexpr float none = std::numeric_limits<float>::quiet_NaN(), far = 3e38F;
  EXPECT_EQ(extentOf(renderObject(cloudOf({{1, 2, 3}, {none, 0, 0}}), 100)), cv::Rect(48, 48, 5, 5));
  EXPECT_GT(extentOf(renderObject(cloudOf({{-far, 0, 0}, {far, far, -far}}), 100)).width, 50);
  EXPECT_GT(extentOf(renderObject(cloudOf({{0, 0, 0}, {1, 0, 0}}), 100)).width, 70);  // a line has no face
  EXPECT_EQ(extentOf(renderObject(cloudOf({{0, 0, 0}, {1, 0, 0}}), 1)).width, 1);
  const PointCloud hole = cloudOf({{none, 0, 0}}), torn = cloudOf({{1, 2, 3}}, {{1, 2, 3}, {4, 5, 6}});
  EXPECT_THAT([&] { renderObject(hole); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { renderObject({}); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { renderObject(torn); }, FailsWith(ErrorCode::invalidInput));
  for (const int size : {0, -1, 5000})
    EXPECT_THAT([&] { renderObject(board(0), size); }, FailsWith(ErrorCode::invalidOption));
  EXPECT_THAT([&] { renderObject(board(0), 100, with(Background::kept, -1)); },
              FailsWith(ErrorCode::invalidOption));
}

}  // namespace
}  // namespace estancia
