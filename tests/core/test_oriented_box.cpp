// Boxes that stand upright: what they share, and the one around points.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/oriented_box.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "support/errors.hpp"

namespace estancia {
namespace {

using test::FailsWith;

TEST(OrientedBox, SharesItsRestWhereItIsMovedAlongItsOwnSideAndNothingWithoutVolume) {
  for (int degrees = 0; degrees < 180; degrees += 5) {
    const double yaw = degrees * std::numbers::pi / 180;
    const OrientedBox mug{{13, 2, 0.9}, {0.1, 0.08, 0.1}, yaw};
    OrientedBox moved = mug;
    moved.center += 0.02 * cv::Point3d(std::cos(yaw), std::sin(yaw), 0);
    EXPECT_NEAR(intersectionOverUnion(mug, moved), 0.08 / 0.12, 1e-6) << degrees;
    EXPECT_NEAR(intersectionOverUnion(moved, mug), 0.08 / 0.12, 1e-6) << degrees;
  }
  const OrientedBox box{{}, {1, 1, 1}, 0};
  EXPECT_EQ(intersectionOverUnion(box, {{}, {1, 1, 0}, 0}), 0);
  EXPECT_EQ(intersectionOverUnion({{}, {1, 1, 0}, 0}, box), 0);
  EXPECT_EQ(intersectionOverUnion(box, {{std::nan(""), 0, 0}, {1, 1, 1}, 0}), 0);
  EXPECT_EQ(intersectionOverUnion(box, {{}, {1, 1, 1}, std::nan("")}), 0);
}

TEST(OrientedBox, AgreesWithCountingPoints) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-1, 1), side(0.5, 2), turn(-4, 4), anywhere(-3, 3);
  const auto holds = [](const OrientedBox& box, const cv::Point3d& p) {
    const double c = std::cos(box.yaw), s = std::sin(box.yaw);
    const cv::Point3d d = p - box.center;
    return std::abs(c * d.x + s * d.y) < box.size.x / 2 && std::abs(-s * d.x + c * d.y) < box.size.y / 2 &&
           std::abs(d.z) < box.size.z / 2;
  };
  for (int pair = 0; pair < 20; ++pair) {
    const OrientedBox a{{place(random), place(random), place(random)},
                        {side(random), side(random), side(random)},
                        turn(random)};
    const OrientedBox b{{place(random), place(random), place(random)},
                        {side(random), side(random), side(random)},
                        turn(random)};
    double both = 0, any = 0;
    for (int i = 0; i < 100000; ++i) {
      const cv::Point3d p{anywhere(random), anywhere(random), anywhere(random)};
      const bool inA = holds(a, p), inB = holds(b, p);
      both += inA && inB;
      any += inA || inB;
    }
    EXPECT_NEAR(intersectionOverUnion(a, b), both / any, 0.05) << pair;
  }
}

TEST(OrientedBox, FitsPointsOfATurnedBoxButNotTheirOutliersAndIsAsThickAsAsked) {
  std::vector<cv::Point3d> points;
  const double yaw = 0.4, far = 1000;
  for (double x = -1; x <= 1; x += 0.05)
    for (double y = -0.3; y <= 0.3; y += 0.05)
      for (double z = 0; z <= 0.7; z += 0.05)
        points.emplace_back(far + std::cos(yaw) * x - std::sin(yaw) * y,
                            std::sin(yaw) * x + std::cos(yaw) * y, z);
  const OrientedBox expected{{far, 0, 0.35}, {2, 0.6, 0.7}, yaw};
  EXPECT_GT(intersectionOverUnion(fitBox(points, 0, 0.01), expected), 0.8);
  points.emplace_back(far + 5, 5, 5);
  EXPECT_LT(intersectionOverUnion(fitBox(points, 0, 0.01), expected), 0.3);
  EXPECT_GT(intersectionOverUnion(fitBox(points, 0.005, 0.01), expected), 0.8);
  const OrientedBox box = fitBox(std::vector<cv::Point3d>{{1, 2, 3}}, 0.1, 0.02);
  EXPECT_EQ(box.center, cv::Point3d(1, 2, 3));
  EXPECT_EQ(box.size, cv::Point3d(0.02, 0.02, 0.02));
  EXPECT_THAT([] { fitBox({}, 0, 0.01); }, FailsWith(ErrorCode::invalidInput));
}

}  // namespace
}  // namespace estancia
