// SPDX-License-Identifier: Apache-2.0
#include "recognition/pose_error.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "estancia/core/error.hpp"
#include "support/errors.hpp"

namespace estancia::experiments {
namespace {

TEST(PoseError, MeasuresAtTheModelsCenter) {
  const cv::Affine3d truth(cv::Vec3d(0.1, 0.2, 0.3), cv::Vec3d(1, 2, 3));
  const cv::Point3d center(0.2, 0, 0.5);
  const cv::Affine3d turn(cv::Vec3d(0, 0, 10 * CV_PI / 180));
  const cv::Affine3d about = turn.translate(cv::Vec3d(center - turn * center));
  const PoseError e = poseError(truth * about, truth, center);
  EXPECT_NEAR(e.translation, 0, 1e-12);
  EXPECT_NEAR(e.rotation, 10, 1e-9);
  EXPECT_TRUE(isCorrect(e));
  EXPECT_FALSE(isCorrect({0.021, 0}));
  EXPECT_FALSE(isCorrect({0, 15.1}));
}

TEST(PoseError, ASymmetricObjectMayBeTurned) {
  const cv::Affine3d truth(cv::Vec3d(0.1, 0.2, 0.3), cv::Vec3d(1, 2, 3));
  const cv::Point3d center(0.2, 0.1, 0.5);
  const auto turns = turnsAround(center, {0, 0, 2}, 4);
  ASSERT_EQ(turns.size(), 3U);
  for (const cv::Affine3d& turn : turns) {
    EXPECT_GT(poseError(truth * turn, truth, center).rotation, 89);
    const PoseError e = poseError(truth * turn, truth, center, turns);
    EXPECT_NEAR(e.rotation, 0, 1e-6);
    EXPECT_NEAR(e.translation, 0, 1e-12);
  }
}

TEST(PoseError, CenterIsOfTheFinitePoints) {
  PointCloud cloud;
  cloud.points = {{0, 0, 0}, {std::nanf(""), 9, 9}, {2, 4, 6}, {2, 4, 6}};
  EXPECT_EQ(centerOf(cloud), cv::Point3d(1, 2, 3));
  EXPECT_THAT([] { centerOf(PointCloud()); }, test::FailsWith(ErrorCode::invalidInput, "0"));
}

}  // namespace
}  // namespace estancia::experiments
