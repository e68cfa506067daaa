// SPDX-License-Identifier: Apache-2.0
#include "estancia/ros/transform_tree.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "estancia/core/rigid.hpp"

namespace estancia::ros {
namespace {

constexpr std::int64_t ms = 1'000'000;

StampedPose transformAt(std::int64_t time, const char* parent, const char* child, double x, double yaw = 0) {
  return {{time, parent}, child, {x, 0, 0, 0, 0, std::sin(yaw / 2), std::cos(yaw / 2)}};
}

TransformTree robot() {
  TransformTree tree(500 * ms, 50 * ms);
  tree.add(transformAt(0, "base", "camera", 0.5), true);
  tree.add(transformAt(0, "odom", "base", 0), false);
  tree.add(transformAt(100 * ms, "odom", "base", 1, M_PI / 2), false);
  tree.add(transformAt(0, "map", "odom", 10), true);
  return tree;
}

TEST(TransformTree, ChainsAreInterpolatedInTime) {
  const TransformTree tree = robot();
  EXPECT_EQ(tree.rootOf("camera"), "map");
  EXPECT_TRUE(tree.isMoving("camera"));
  EXPECT_FALSE(tree.isMoving("odom"));
  const auto camera = tree.find("map", "camera", 50 * ms);
  ASSERT_TRUE(camera);
  EXPECT_NEAR(angleOf(*camera), M_PI / 4, 1e-12);
  EXPECT_NEAR(camera->translation()[0], 10 + 0.5 + 0.5 * std::cos(M_PI / 4), 1e-12);
  EXPECT_NEAR(camera->translation()[1], 0.5 * std::sin(M_PI / 4), 1e-12);
}

TEST(TransformTree, ATransformHoldsForAShortTimeOnly) {
  const TransformTree tree = robot();
  EXPECT_TRUE(tree.find("odom", "base", 140 * ms));
  EXPECT_FALSE(tree.find("odom", "base", 160 * ms));
  EXPECT_TRUE(tree.find("odom", "base", -40 * ms));
  EXPECT_FALSE(tree.find("odom", "base", -60 * ms));
}

TEST(TransformTree, LongGapsAreNotInterpolated) {
  TransformTree tree(500 * ms, 50 * ms);
  tree.add(transformAt(0, "odom", "base", 0), false);
  tree.add(transformAt(600 * ms, "odom", "base", 6), false);
  EXPECT_FALSE(tree.find("odom", "base", 300 * ms));
  EXPECT_NEAR(tree.find("odom", "base", 570 * ms)->translation()[0], 6, 1e-12);
}

TEST(TransformTree, BadTransformsAreNotTaken) {
  TransformTree tree(500 * ms, 50 * ms);
  EXPECT_FALSE(tree.add({{0, "a"}, "b", {0, 0, 0, 0, 0, 0, 0}}, false));
  EXPECT_FALSE(tree.add({{0, "a"}, "a", {}}, false));
  EXPECT_FALSE(tree.add({{0, "a"}, "b", {std::numeric_limits<double>::quiet_NaN()}}, false));
  EXPECT_TRUE(tree.empty());
}

TEST(TransformTree, InterpolationTakesTheShorterArc) {
  const Pose quarter{0, 0, 0, 0, 0, std::sqrt(0.5), std::sqrt(0.5)};
  const Pose same{0, 0, 0, 0, 0, -std::sqrt(0.5), -std::sqrt(0.5)};
  EXPECT_NEAR(angleOf(rigidOf(interpolated(quarter, same, 0.5)).inv() * rigidOf(quarter)), 0, 1e-9);
}

}  // namespace
}  // namespace estancia::ros
