// SPDX-License-Identifier: Apache-2.0
#include "estancia/stats/trajectory_error.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "estancia/core/pose.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using test::FailsWith;

/// A path through space that lies in no plane.
std::vector<Pose> spiral(std::size_t count) {
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < count; ++i) {
    const double t = 0.1 * static_cast<double>(i);
    poses.push_back(
        poseOf({cv::Vec3d(0.3 * std::sin(t), t, 0.1), cv::Vec3d(std::cos(t), std::sin(2 * t), 0.2 * t)}));
  }
  return poses;
}

std::vector<Pose> moved(const cv::Affine3d& by, const std::vector<Pose>& poses) {
  std::vector<Pose> result;
  for (const Pose& pose : poses) result.push_back(poseOf(by * rigidOf(pose)));
  return result;
}

TEST(Rigid, PosesBecomeTransformsAndBack) {
  for (const double angle : {0.0, 1e-3, 0.5, 2.0, 3.1, std::numbers::pi}) {
    const cv::Affine3d transform(cv::Vec3d(0.6, -0.48, 0.64) * angle, cv::Vec3d(1, -2, 3));
    const Pose pose = poseOf(transform);
    EXPECT_NEAR(cv::norm(rigidOf(pose).matrix - transform.matrix), 0, 1e-9) << angle;
    EXPECT_NEAR(angleOf(transform), angle, 1e-6);
    EXPECT_NEAR(pose.qx * pose.qx + pose.qy * pose.qy + pose.qz * pose.qz + pose.qw * pose.qw, 1, 1e-12);
  }
  const Pose level = Pose::planar(1, 2, 0.7);
  const cv::Vec3d ahead = rigidOf(level).rotation() * cv::Vec3d(0, 0, 1);
  EXPECT_NEAR(ahead[0], std::cos(0.7), 1e-12);
  EXPECT_NEAR(ahead[1], std::sin(0.7), 1e-12);
}

TEST(AbsoluteTrajectoryError, AnotherMapFrameIsNoError) {
  const auto truth = spiral(50);
  const cv::Affine3d shift(cv::Vec3d(0.4, -1.2, 2.0), cv::Vec3d(10, -3, 0.5));
  const auto error = absoluteTrajectoryError(moved(shift, truth), truth);
  EXPECT_EQ(error.poses, 50U);
  EXPECT_NEAR(error.rmse, 0, 1e-9);
  EXPECT_NEAR(error.max, 0, 1e-9);
  EXPECT_NEAR(cv::norm((rigidOf(error.truthFromEstimate) * shift).matrix - cv::Matx44d::eye()), 0, 1e-6);
}

TEST(AbsoluteTrajectoryError, MeasuresWhatNoMotionExplains) {
  // Four corners of a square; the estimate is the square 10 % larger: every corner is off by a tenth of √½.
  const std::vector<Pose> truth{
      {.x = 0.5, .y = 0.5}, {.x = -0.5, .y = 0.5}, {.x = -0.5, .y = -0.5}, {.x = 0.5, .y = -0.5}};
  std::vector<Pose> larger = truth;
  for (Pose& pose : larger) pose.x *= 1.1, pose.y *= 1.1;
  const auto error = absoluteTrajectoryError(larger, truth);
  const double off = 0.1 * std::sqrt(0.5);
  EXPECT_NEAR(error.rmse, off, 1e-12);
  EXPECT_NEAR(error.mean, off, 1e-12);
  EXPECT_NEAR(error.median, off, 1e-12);
  EXPECT_NEAR(error.max, off, 1e-12);
}

TEST(AbsoluteTrajectoryError, AMirroredPathIsNotTurnedInsideOut) {
  auto mirrored = spiral(50);
  for (Pose& pose : mirrored) pose.x = -pose.x;
  EXPECT_GT(absoluteTrajectoryError(mirrored, spiral(50)).rmse, 0.05);
}

TEST(RelativePoseError, IsTheDriftOfOneStep) {
  // Every step is 1 cm and 1° too much.
  const cv::Affine3d step(cv::Vec3d(0, 0, 0), cv::Vec3d(0.1, 0, 0));
  const cv::Affine3d wrong(cv::Vec3d(0, 0, std::numbers::pi / 180), cv::Vec3d(0.11, 0, 0));
  std::vector<Pose> truth{{}}, estimated{{}};
  for (int i = 0; i < 20; ++i) {
    truth.push_back(poseOf(rigidOf(truth.back()) * step));
    estimated.push_back(poseOf(rigidOf(estimated.back()) * wrong));
  }
  const auto error = relativePoseError(estimated, truth);
  EXPECT_EQ(error.pairs, 20U);
  EXPECT_NEAR(error.translationRmse, 0.01, 1e-6);
  EXPECT_NEAR(error.rotationRmse, 1, 1e-4);
  EXPECT_NEAR(relativePoseError(estimated, truth, 5).rotationRmse, 5, 1e-3);
  EXPECT_EQ(relativePoseError(estimated, truth, 100).pairs, 0U);
  EXPECT_NEAR(pathLength(truth), 2, 1e-9);
}

TEST(TrajectoryErrors, RefuseWhatIsNoPair) {
  const auto error = [](const std::vector<Pose>& estimated, const std::vector<Pose>& truth) {
    return [=] { absoluteTrajectoryError(estimated, truth); };
  };
  EXPECT_THAT(error(spiral(3), spiral(4)), FailsWith(ErrorCode::mismatch));
  EXPECT_THAT(error({}, {}), FailsWith(ErrorCode::mismatch));
  auto broken = spiral(4);
  broken[2].y = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(error(broken, spiral(4)), FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT(error(spiral(4), broken), FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { relativePoseError(spiral(4), spiral(4), 0); }, FailsWith(ErrorCode::invalidInput));
}

}  // namespace
}  // namespace estancia
