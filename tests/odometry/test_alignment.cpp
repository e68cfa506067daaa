// SPDX-License-Identifier: Apache-2.0
#include "estancia/odometry/alignment.hpp"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "estancia/core/rigid.hpp"
#include "support/room.hpp"

namespace estancia::test {
namespace {

using odometry::align;
using odometry::Alignment;
using odometry::AlignmentTarget;
using odometry::AlignmentTerm;
using odometry::Pyramid;

const CameraIntrinsics kCamera{160, 120, 140, 140, 79.5, 59.5};

Pyramid seenFrom(const Pose& pose, double exposure = 1) {
  const RoomView view = render(pose, kCamera, 0, 1);
  return odometry::pyramidOf(odometry::reducedImage(view.bgr * exposure, view.depth, kCamera, 160, 6), 3);
}

/// A wall, 2 m away; gray where `value` says so (0 to 1, by column and row).
template <typename Value>
Pyramid wall(const Value& value) {
  odometry::RgbdImage image{kCamera, cv::Mat(120, 160, CV_32F), cv::Mat(120, 160, CV_32F, cv::Scalar(2))};
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 160; ++x) image.gray.at<float>(y, x) = static_cast<float>(value(x, y));
  return odometry::pyramidOf(image, 3);
}

double distanceOf(const Alignment& alignment, const Pose& truth) {
  return cv::norm(alignment.transform.translation() - rigidOf(truth).translation());
}

TEST(Alignment, FindsAPoseAmongTwoOthers) {
  const Pose a = Pose::planar(0, 0, 0), b = Pose::planar(0.1, 0.3, 0.3),
             between = Pose::planar(0.1, 0.1, 0.12);
  const Pyramid left = seenFrom(a), right = seenFrom(b), source = seenFrom(between, 0.8);  // a darker image
  const AlignmentTarget targets[] = {{&left, rigidOf(a)}, {&right, rigidOf(b)}};
  for (const auto term : {AlignmentTerm::hybrid, AlignmentTerm::automatic}) {
    const Alignment found = align(source, targets, rigidOf(Pose::planar(0.07, 0.08, 0.1)), {.term = term});
    ASSERT_TRUE(found.solved);
    EXPECT_LT(distanceOf(found, between), 0.005);
    EXPECT_GT(found.overlap, 0.7);
    EXPECT_GT(found.correlation, 0.9);
    EXPECT_LT(found.spread, 0.01);
  }
}

TEST(Alignment, TextureHoldsAlongAWall) {
  const auto tiles = [](int x, int y) { return 0.3 + 0.4 * ((x / 9 + y / 7) % 2); };
  const Pyramid still = wall(tiles), moved = wall([&](int x, int y) { return tiles(x + 2, y); });
  const AlignmentTarget target{&still, cv::Affine3d::Identity()};
  const Alignment found = align(moved, {&target, 1}, cv::Affine3d::Identity(), {});
  ASSERT_TRUE(found.solved);
  EXPECT_NEAR(found.transform.translation()[0], 2 * 2 / 140.0, 0.003);  // 2 pixels at 2 m
  EXPECT_LT(found.spread, 0.05);
  const Alignment byDepth =
      align(moved, {&target, 1}, cv::Affine3d::Identity(), {.term = AlignmentTerm::depth});
  EXPECT_TRUE(!byDepth.solved || byDepth.spread > 0.3) << byDepth.spread;
}

}  // namespace
}  // namespace estancia::test
