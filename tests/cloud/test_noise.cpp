// Noise, spacing and viewpoint of a cloud, from its points alone.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/cloud/viewpoint.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <opencv2/core/affine.hpp>

#include "estancia/cloud/resolution.hpp"
#include "support/clouds.hpp"
#include "support/errors.hpp"
#include "support/numbers.hpp"

namespace estancia {
namespace {

using test::cloudOf;
using test::FailsWith;
using test::quietNan;

/// A bowl of 2 m, a point each 10 mm.
PointCloud bowl(float scale = 1) {
  std::vector<cv::Point3f> points;
  for (int y = -100; y < 100; ++y)
    for (int x = -100; x < 100; ++x) {
      const float u = 0.01F * static_cast<float>(x), v = 0.01F * static_cast<float>(y);
      points.emplace_back(scale * u, scale * v, scale * (2 - 0.3F * (u * u + v * v)));
    }
  return cloudOf(std::move(points));
}

TEST(Noise, OfADepthCameraGrowsWithDepth) {
  std::vector<cv::Point3f> points;
  for (int i = 0; i < 20000; ++i)
    points.emplace_back(i % 2 == 0 ? cv::Point3f(0.3F, 0, 1) : cv::Point3f(0, 0.9F, 3));
  const PointCloud noisy = withDepthNoise(cloudOf(points), 0.002, 0.001, 4);
  for (int part = 0; part < 2; ++part) {
    double along = 0, across = 0;
    for (std::size_t i = static_cast<std::size_t>(part); i < points.size(); i += 2) {
      const cv::Point3f& p = noisy.points[i];
      along += std::pow(static_cast<double>(p.z - points[i].z), 2) * 2 / 20000;
      const float slope = part == 0 ? p.y / p.z : p.x / p.z;  // slope of the direction that has no noise
      across += std::pow(static_cast<double>(slope), 2) * 2 / 20000;
    }
    EXPECT_NEAR(std::sqrt(along), part == 0 ? 0.002 : 0.018, part == 0 ? 1e-4 : 9e-4);
    EXPECT_NEAR(std::sqrt(across), 0.001, 5e-5) << "the same angle at any depth";
  }
  EXPECT_EQ(withDepthNoise(cloudOf(points), 0.002, 0.001, 4).points, noisy.points);
  EXPECT_THAT([&] { withDepthNoise(noisy, -1, 0, 1); }, FailsWith(ErrorCode::invalidOption));
  EXPECT_THAT([&] { withDepthNoise(noisy, 0, quietNan, 1); }, FailsWith(ErrorCode::invalidOption));
}

// The numbers themselves, so that no standard library's own distribution slips in.
TEST(Noise, IsTheSameEverywhere) {
  const PointCloud noisy = withGaussianNoise(cloudOf({{0, 0, 0}, {quietNan, 1, 1}, {0, 0, 0}}), 1, 42);
  EXPECT_EQ(noisy.points[0], withGaussianNoise(cloudOf({{0, 0, 0}}), 1, 42).points[0]);
  EXPECT_TRUE(std::isnan(noisy.points[1].x));
  EXPECT_NE(noisy.points[2], noisy.points[0]);
  const PointCloud whole = withGaussianNoise(cloudOf({{0, 0, 0}, {1, 1, 1}, {0, 0, 0}}), 1, 42);
  EXPECT_EQ(whole.points[2], noisy.points[2]);  // a hole takes its share
  EXPECT_NE(withGaussianNoise(cloudOf({{0, 0, 0}}), 1, 43).points[0], noisy.points[0]);
  EXPECT_FLOAT_EQ(noisy.points[0].x, -1.07717454F);
  EXPECT_FLOAT_EQ(noisy.points[0].y, -1.28606343F);
  EXPECT_FLOAT_EQ(noisy.points[0].z, 1.09451985F);
}

TEST(Noise, RefusesWhatIsNoDeviation) {
  for (const double sigma : {-0.001, std::nan(""), HUGE_VAL})
    EXPECT_THAT([&] { withGaussianNoise(bowl(), sigma, 1); }, FailsWith(ErrorCode::invalidOption));
  EXPECT_EQ(withGaussianNoise(bowl(), 0, 1).points, bowl().points);
}

TEST(Resolution, IsTheDistanceToTheNextPlace) {
  EXPECT_NEAR(resolutionOf(bowl()), 0.0101, 0.0002);
  EXPECT_NEAR(resolutionOf(bowl(1000)), 10.1, 0.2);
  PointCloud twice = bowl();
  const std::vector<cv::Point3f> once = twice.points;
  for (int copy = 0; copy < 9; ++copy) twice.points.insert(twice.points.end(), once.begin(), once.end());
  EXPECT_NEAR(resolutionOf(twice), 0.0101, 0.0002);
  EXPECT_EQ(resolutionOf(PointCloud()), 0);
  EXPECT_EQ(resolutionOf(cloudOf({{1, 2, 3}, {quietNan, 1, 1}})), 0);
  EXPECT_EQ(resolutionOf(cloudOf(std::vector<cv::Point3f>(1000, {1, 2, 3}))), 0);
  EXPECT_EQ(resolutionOf(cloudOf({{0, 0, 0}, {3, 4, 0}})), 5);
}

TEST(EstimateNoise, FindsWhatWasPutIn) {
  for (const float scale : {1.F, 1000.F}) {
    EXPECT_LT(estimateNoise(bowl(scale)), 1e-4 * scale);
    for (const double sigma : {0.001, 0.02}) {
      const PointCloud noisy = withGaussianNoise(bowl(scale), sigma * scale, 9);
      EXPECT_NEAR(estimateNoise(noisy, 2) / scale, sigma, 0.1 * sigma);
      EXPECT_EQ(estimateNoise(noisy, 1), estimateNoise(noisy, 3));
    }
  }
}

TEST(EstimateNoise, IsNothingWhereThereIsNoSurface) {
  EXPECT_EQ(estimateNoise(PointCloud()), 0);
  EXPECT_EQ(estimateNoise(cloudOf({{1, 2, 3}})), 0);
  EXPECT_EQ(estimateNoise(cloudOf(std::vector<cv::Point3f>(1000, {1, 2, 3}))), 0);
  EXPECT_EQ(estimateNoise(cloudOf({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}})), 0);
  std::vector<cv::Point3f> line;
  line.reserve(500);
  for (int i = 0; i < 500; ++i) line.emplace_back(static_cast<float>(i), 0.F, 0.F);
  EXPECT_EQ(estimateNoise(cloudOf(line)), 0);
}

/// What a camera at the origin sees of a ball on a floor before a wall, every other pixel; as an unorganized
/// cloud.
PointCloud roomWithBall() {
  std::vector<cv::Point3f> points;
  const cv::Vec3d middle(0.1, 0.1, 1.2);
  for (int v = 0; v < 480; v += 2)
    for (int u = 0; u < 640; u += 2) {
      const cv::Vec3d ray((u - 319.5) / 525, (v - 239.5) / 525, 1);
      double depth = 2.2;                                      // the wall
      if (ray[1] > 0) depth = std::min(depth, 0.35 / ray[1]);  // the floor
      const double a = ray.dot(ray), b = ray.dot(middle), c = middle.dot(middle) - 0.15 * 0.15;
      if (b * b - a * c > 0) depth = std::min(depth, (b - std::sqrt(b * b - a * c)) / a);
      points.emplace_back(cv::Vec3f(ray * depth));
    }
  return cloudOf(std::move(points));
}

PointCloud organized(PointCloud cloud) {
  cloud.width = 320;
  cloud.height = 240;
  return cloud;
}

PointCloud moved(PointCloud cloud, const cv::Affine3d& by) {
  for (cv::Point3f& p : cloud.points) p = by * cv::Point3d(p);
  return cloud;
}

const cv::Affine3d motion(cv::Vec3d(0.9, -1.4, 0.6), cv::Vec3d(1.5, -2, 0.7));

TEST(Viewpoint, IsWherePointsLieEvenly) {
  for (const double noise : {0.0, 0.01}) {
    const PointCloud cloud = withGaussianNoise(roomWithBall(), noise, 3);
    EXPECT_LT(unevenness(drawnFrom(cloud.points, 8000), {}), even);
    const auto found = findViewpoints(moved(cloud, motion).points, 2);
    ASSERT_FALSE(found.empty()) << noise;
    EXPECT_LT(cv::norm(found.front() - cv::Point3d(motion.translation())), 0.25) << noise << ", at 1.8 m";
  }
}

TEST(Viewpoint, OfAGridIsTheCenterOfProjection) {
  const cv::Point3d truth(motion.translation());
  PointCloud cloud = organized(moved(roomWithBall(), motion));
  EXPECT_LT(cv::norm(*viewpointOfGrid(cloud) - truth), 1e-3);
  for (std::size_t i = 0; i < cloud.points.size(); i += 3)
    cloud.points[i].x = std::numeric_limits<float>::quiet_NaN();
  EXPECT_LT(cv::norm(*viewpointOfGrid(cloud) - truth), 1e-3) << "with holes";
  PointCloud depth = roomWithBall();  // depth's own error does not move the rays
  for (std::size_t i = 0; i < depth.points.size(); ++i)
    depth.points[i] *= 1 + 0.02F * std::sin(static_cast<float>(i));
  EXPECT_LT(cv::norm(*viewpointOfGrid(organized(moved(depth, motion))) - truth), 1e-3);
  EXPECT_LT(cv::norm(*viewpointOfGrid(moved(organized(withGaussianNoise(roomWithBall(), 0.003, 3)), motion)) -
                     truth),
            0.1)
      << "across the rays it does, at 1.8 m";
}

TEST(Viewpoint, NoneOfWhatIsNoProjection) {
  const PointCloud room = roomWithBall();
  EXPECT_FALSE(viewpointOfGrid(room)) << "unorganized";
  PointCloud shuffled = organized(room);
  for (std::size_t i = 0; i < shuffled.points.size(); ++i)
    std::swap(shuffled.points[i], shuffled.points[i * 7919 % shuffled.points.size()]);
  EXPECT_FALSE(viewpointOfGrid(shuffled));
  PointCloud wall = organized(room);
  for (std::size_t i = 0; i < wall.points.size(); ++i)
    wall.points[i] = {static_cast<float>(i % 320) * 0.01F, static_cast<float>(i / 320) * 0.01F, 2};
  EXPECT_FALSE(viewpointOfGrid(wall)) << "a plane is seen the same from everywhere";
  wall.points.assign(wall.points.size(), {1, 2, 3});
  EXPECT_FALSE(viewpointOfGrid(wall));
  wall.points.assign(wall.points.size(), {std::numeric_limits<float>::quiet_NaN(), 0, 0});
  EXPECT_FALSE(viewpointOfGrid(wall));
}

TEST(Viewpoint, NoneForPointsFromAllSides) {
  PointCloud ball;
  for (int i = 0; i < 20000; ++i) {
    const double z = 1 - (2 * i + 1) / 20000.0, turn = 2.399963 * i, r = std::sqrt(1 - z * z);
    ball.points.emplace_back(cv::Vec3f(cv::Vec3d(r * std::cos(turn), r * std::sin(turn), z)));
  }
  EXPECT_FALSE(directionOfView(ball.points, 0.025));
  EXPECT_TRUE(findViewpoints(std::vector<cv::Point3f>(10, {1, 2, 3})).empty());
  EXPECT_TRUE(findViewpoints(std::vector<cv::Point3f>(2000, {1, 2, 3})).empty());
  EXPECT_TRUE(findViewpoints({}).empty());
}

}  // namespace
}  // namespace estancia
