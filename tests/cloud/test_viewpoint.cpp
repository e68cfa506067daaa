// Where the sensor of a cloud stood, and whether a cloud shows one side.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/cloud/viewpoint.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <opencv2/core/affine.hpp>

#include "estancia/cloud/resolution.hpp"

namespace estancia {
namespace {

/// What a camera at the origin sees of a ball on a floor before a wall, every other pixel; as an unorganized
/// cloud.
PointCloud roomWithBall() {
  PointCloud cloud;
  const cv::Vec3d middle(0.1, 0.1, 1.2);
  for (int v = 0; v < 480; v += 2)
    for (int u = 0; u < 640; u += 2) {
      const cv::Vec3d ray((u - 319.5) / 525, (v - 239.5) / 525, 1);
      double depth = 2.2;                                      // the wall
      if (ray[1] > 0) depth = std::min(depth, 0.35 / ray[1]);  // the floor
      const double a = ray.dot(ray), b = ray.dot(middle), c = middle.dot(middle) - 0.15 * 0.15;
      if (b * b - a * c > 0) depth = std::min(depth, (b - std::sqrt(b * b - a * c)) / a);
      cloud.points.emplace_back(cv::Vec3f(ray * depth));
    }
  cloud.width = cloud.points.size();
  cloud.height = 1;
  return cloud;
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
    const auto found = findViewpoint(moved(cloud, motion).points, 2);
    ASSERT_TRUE(found) << noise;
    EXPECT_LT(cv::norm(*found - cv::Point3d(motion.translation())), 0.25) << noise << ", at 1.8 m";
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
  EXPECT_FALSE(findViewpoint(std::vector<cv::Point3f>(10, {1, 2, 3})));
  EXPECT_FALSE(findViewpoint(std::vector<cv::Point3f>(2000, {1, 2, 3})));
  EXPECT_FALSE(findViewpoint({}));
}

}  // namespace
}  // namespace estancia
