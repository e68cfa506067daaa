// SPDX-License-Identifier: Apache-2.0
#include "estancia/figures/cloud_image.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

/// A square of `half` at distance z before the sensor.
PointCloud square(float half, float z) {
  PointCloud cloud;
  for (float x = -half; x <= half; x += half / 40)
    for (float y = -half; y <= half; y += half / 40) cloud.points.emplace_back(x, y, z);
  cloud.width = cloud.points.size();
  cloud.height = 1;
  return cloud;
}

CloudLayer layer(const PointCloud& cloud, const cv::Vec3b& color) {
  return {&cloud, cv::Affine3d::Identity(), color, {}};
}

int count(const cv::Mat& image, const cv::Vec3b& color) {
  cv::Mat same;
  cv::inRange(image, color, color, same);
  return cv::countNonZero(same);
}

const cv::Vec3b red(0, 0, 255), blue(255, 0, 0);

TEST(CloudImage, FillsTheImageAndKeepsShapes) {
  const PointCloud wall = square(1, 3);
  const std::array layers{layer(wall, red)};
  const cv::Mat image = drawClouds(layers, {.width = 400, .height = 300});
  ASSERT_EQ(image.size(), cv::Size(400, 300));
  cv::Mat drawn;
  cv::inRange(image, red, red, drawn);
  const cv::Rect box = cv::boundingRect(drawn);
  EXPECT_NEAR(box.height, 282, 12);                       // 94 % of the height …
  EXPECT_NEAR(box.width, box.height, 4);                  // … and square
  EXPECT_GT(cv::countNonZero(drawn), 0.95 * box.area());  // without holes
}

TEST(CloudImage, WhatIsNearerHidesWhatIsBehindIt) {
  const PointCloud wall = square(1, 3), thing = square(0.3F, 2);
  const std::array front{layer(wall, red), layer(thing, blue)};
  EXPECT_GT(count(drawClouds(front), blue), 10000);
  const PointCloud hidden = square(0.3F, 4);
  const std::array behind{layer(wall, red), layer(hidden, blue)};
  EXPECT_EQ(count(drawClouds(behind), blue), 0);
}

TEST(CloudImage, MovesWithPoseAndDrawsEdges) {
  const PointCloud wall = square(1, 3);
  PointCloud pair;
  pair.points = {{-0.5F, 0, 2}, {0.5F, 0, 2}};
  pair.width = 2;
  pair.height = 1;
  const std::array<std::array<std::uint32_t, 2>, 2> edges{
      {{0, 1}, {0, 7}}};  // color of a point that is not finite: left out
  const std::array layers{layer(wall, red), CloudLayer{&pair, cv::Affine3d::Identity(), blue, edges}};
  const int across = count(drawClouds(layers), blue);
  EXPECT_GT(across, 200);
  const std::array away{layer(wall, red),
                        CloudLayer{&pair, cv::Affine3d(cv::Vec3d(), cv::Vec3d(0, 0, 5)), blue, edges}};
  EXPECT_EQ(count(drawClouds(away), blue), 0);
}

TEST(CloudImage, RefusesNothingToDraw) {
  EXPECT_THAT([] { drawClouds({}); }, FailsWith(ErrorCode::invalidInput));
  PointCloud none;
  none.points = {{std::numeric_limits<float>::quiet_NaN(), 0, 0}};
  none.width = none.height = 1;
  const std::array layers{layer(none, red)};
  EXPECT_THAT([&] { drawClouds(layers); }, FailsWith(ErrorCode::invalidInput));
  const PointCloud wall = square(1, 3);
  const std::array one{layer(wall, red)};
  EXPECT_THAT([&] { drawClouds(one, {.width = 2}); }, FailsWith(ErrorCode::invalidOption));
}

}  // namespace
}  // namespace estancia::test
