// Tracking with a motion prior: wheel odometry that is right, noisy, wrong, or missing.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/odometry/prior.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "estancia/core/error.hpp"
#include "estancia/core/pose.hpp"
#include "support/errors.hpp"
#include "support/room.hpp"

namespace estancia::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

/// The true motion in another frame, each turn off by `degrees` (standard deviation).
MotionPrior wheels(const Drive& drive, double degrees) {
  std::mt19937 random(3);
  std::normal_distribution<double> gauss;
  MotionPrior prior{Pose::planar(5, -3, 2)};
  for (std::size_t i = 1; i < drive.size(); ++i) {
    const cv::Affine3d step = rigidOf(*drive.frame(i - 1).pose).inv() * rigidOf(*drive.frame(i).pose);
    const cv::Affine3d off(cv::Vec3d(0, degrees * std::numbers::pi / 180 * gauss(random), 0));
    prior.push_back(poseOf(rigidOf(*prior.back()) * step * off));
  }
  return prior;
}

TEST(MotionPrior, ErrorsOfStepsAddUpAndATurnSwingsWhatFollows) {
  const RgbdOptions options{.odomShift = 10, .odomTurn = 3};
  odometry::PriorTrack prior;
  for (std::size_t i = 0; i <= 4; ++i)
    prior.add(i, Pose{.z = 0.5 * static_cast<double>(i)}, false);  // half a meter ahead a step
  const auto motion = prior.motion(0, 4, options);
  ASSERT_TRUE(motion);
  EXPECT_NEAR(motion->transform.translation()[2], 2, 1e-9);
  const double turn = 3 * std::numbers::pi / 180;
  EXPECT_NEAR(motion->covariance(1, 1), 4 * turn * turn, 1e-9);
  EXPECT_NEAR(motion->covariance(5, 5), 4 * 0.0025, 1e-5);  // ahead: 10 % of each step
  // Written at the first camera, a turn at 0, 0.5, 1 and 1.5 m ahead shifts what does not turn to the side.
  EXPECT_NEAR(motion->covariance(3, 3), 4 * 0.0025 + (0.25 + 1 + 2.25) * turn * turn, 1e-5);
  EXPECT_LT(motion->covariance(1, 3) * motion->covariance(3, 1), 1);
  EXPECT_FALSE(prior.motion(0, 5, options)) << "the prior is shorter than the drive";
}

TEST(MotionPrior, BridgesWhatIsNotSeen) {
  Drive drive(turnAround(40, -12));
  for (std::size_t i = 8; i < 20; ++i) drive.noDepthValues.insert(i);  // it turns by 117° blindly
  const auto alone = trackRgbd(drive);
  EXPECT_GT(alone.lost.size(), 11U);
  const auto guided = trackRgbd(drive, {}, {}, Progress::none(), wheels(drive, 1));
  EXPECT_THAT(guided.lost, IsEmpty());
  EXPECT_THAT(guided.bridged, SizeIs(testing::Ge(12)));
  EXPECT_LT(errorOf(guided, drive), 0.06);
}

TEST(MotionPrior, AWrongOneHardlyHarms) {
  const Drive drive(turnAround(40, -20));
  MotionPrior backwards = wheels(drive, 0);
  std::ranges::reverse(backwards);
  const auto trajectory = trackRgbd(drive, {}, {}, Progress::none(), backwards);
  EXPECT_THAT(trajectory.lost, IsEmpty());
  EXPECT_LT(errorOf(trajectory, drive), 0.05);
}

TEST(MotionPrior, HasAnEntryAFrame) {
  const Drive drive(turnAround(60, -57));
  EXPECT_THAT(caught([&] { trackRgbd(drive, {}, {}, Progress::none(), MotionPrior(2)); }),
              FailsWith(ErrorCode::mismatch));
  EXPECT_THAT(caught([&] { trackRgbd(drive, {.odomTurn = -1}); }), FailsWith(ErrorCode::invalidOption));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(caught([&] { trackRgbd(drive, {.odomShift = nan}); }), FailsWith(ErrorCode::invalidOption));
}

}  // namespace
}  // namespace estancia::test
