// SPDX-License-Identifier: Apache-2.0
#include "estancia/odometry/pose_graph.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace estancia::test {
namespace {

using odometry::optimizePoses;
using odometry::PoseGraphEdge;

const cv::Affine3d step(cv::Vec3d(0, 0, 0.5), cv::Vec3d(1, 0, 0));  // 1 m ahead, then left

/// Twelve steps, nearly once around a circle, each tracked a little wrong.
struct Circle {
  std::vector<cv::Affine3d> truth{cv::Affine3d::Identity()}, poses = truth;
  std::vector<PoseGraphEdge> edges;

  Circle() {
    const cv::Affine3d wrong = step * cv::Affine3d(cv::Vec3d(0, 0, 0.02), cv::Vec3d(0.01, 0, 0));
    for (std::size_t i = 1; i <= 12; ++i) {
      truth.push_back(truth.back() * step);
      poses.push_back(poses.back() * wrong);
      edges.push_back({i, i - 1, wrong, 1e-3 * cv::Matx66d::eye()});
    }
  }
  double error() const { return cv::norm(poses.back().translation() - truth.back().translation()); }
};

TEST(PoseGraph, ALoopSpreadsItsErrorOverTheWay) {
  Circle circle;
  const double drift = circle.error();
  ASSERT_GT(drift, 0.1);
  circle.edges.push_back({12, 0, circle.truth.back(), 1e-6 * cv::Matx66d::eye()});
  const auto off = optimizePoses(circle.poses, circle.edges);
  ASSERT_EQ(off.size(), 13U);
  EXPECT_LT(circle.error(), 0.01);
  EXPECT_LT(cv::norm(circle.poses[6].translation() - circle.truth[6].translation()), 0.1);
  EXPECT_EQ(cv::norm(circle.poses[0].translation()), 0);
}

TEST(PoseGraph, AFalseLoopIsToldByHowFarItIsOff) {
  Circle circle;
  circle.edges.push_back({12, 0, circle.truth.back(), 1e-4 * cv::Matx66d::eye()});
  circle.edges.push_back({11, 1, circle.truth[1].inv() * circle.truth[11], 1e-4 * cv::Matx66d::eye()});
  circle.edges.push_back({6, 0, cv::Affine3d::Identity(), 1e-4 * cv::Matx66d::eye()});  // 4 m off
  const auto off = optimizePoses(circle.poses, circle.edges);
  EXPECT_LT(off[12], 6);
  EXPECT_LT(off[13], 6);
  EXPECT_GT(off[14], 50);
  EXPECT_LT(circle.error(), 0.05);
}

TEST(PoseGraph, MovesOnlyWhatMayMove) {
  Circle circle;
  const std::vector<cv::Affine3d> before = circle.poses;
  circle.edges.push_back({12, 8, circle.truth[8].inv() * circle.truth[12], 1e-6 * cv::Matx66d::eye()});
  std::vector<bool> free(13);
  for (std::size_t i = 8; i < 13; ++i) free[i] = true;
  optimizePoses(circle.poses, circle.edges, free);
  for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(cv::norm(circle.poses[i].matrix - before[i].matrix), 0) << i;
  EXPECT_GT(cv::norm(circle.poses[12].translation() - before[12].translation()), 0.01);
}

TEST(PoseGraph, OnePoseStays) {
  std::vector<cv::Affine3d> poses{step};
  EXPECT_TRUE(optimizePoses(poses, {}).empty());
  EXPECT_EQ(cv::norm(poses[0].translation() - step.translation()), 0);
}

}  // namespace
}  // namespace estancia::test
