// Drives brought together by depth: a rendered room that is seen from other places.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/world/register_drive.hpp"

#include <gtest/gtest.h>

#include "estancia/core/pose.hpp"
#include "support/room.hpp"

namespace estancia {
namespace {

const CameraIntrinsics camera{160, 120, 130, 130, 79.5, 59.5};
/// On the floor.
cv::Affine3d moved(double x, double y, double turn) {
  return {cv::Vec3d(0, 0, turn), cv::Vec3d(x, y, 0)};
}
const cv::Affine3d elsewhere = moved(7, -3, 2.1);

struct Seen {
  std::vector<Observation> observations;
  std::vector<ObservationPose> map, drive;
};

/// A turn in the room, and another one from half a meter beside, with a Kinect's noise.
Seen twoTurns(const cv::Affine3d& driveFrame) {
  Seen seen;
  const auto add = [&](const Pose& pose) {
    const test::RoomView view =
        test::render(pose, camera, 1, static_cast<unsigned>(seen.observations.size()));
    seen.observations.push_back(observe(view.depth, camera));
    return ObservationPose{seen.observations.size() - 1, rigidOf(pose)};
  };
  for (const Pose& pose : test::turnAround(24)) seen.map.push_back(add(pose));
  for (Pose pose : test::turnAround(20)) {
    pose.x += 0.4;
    pose.y += 0.3;
    ObservationPose at = add(pose);
    at.pose = driveFrame.inv() * at.pose;
    seen.drive.push_back(at);
  }
  return seen;
}

TEST(RegisterDrive, FindsTheFrameOfADriveFromARoughGuess) {
  const Seen seen = twoTurns(elsewhere);
  const auto observation = [&](std::size_t frame) { return seen.observations[frame]; };
  const cv::Affine3d guess = moved(0.25, -0.2, 0.1) * elsewhere;
  const auto found = registerDrive(seen.drive, seen.map, observation, guess);
  ASSERT_TRUE(found);
  const cv::Affine3d error = *found * elsewhere.inv();
  EXPECT_LT(cv::norm(error * cv::Vec3d(2, 2, 0) - cv::Vec3d(2, 2, 0)), 0.03);
  EXPECT_LT(angleOf(error), 0.02);
}

TEST(RegisterDrive, FindsNothingWhereDepthDoesNotConfirm) {
  const Seen seen = twoTurns(elsewhere);
  const auto observation = [&](std::size_t frame) { return seen.observations[frame]; };
  EXPECT_FALSE(registerDrive(seen.drive, seen.map, observation, moved(40, 0, 0) * elsewhere));
  // A quarter turn: the room is 5 m long and 4 m wide.
  EXPECT_FALSE(registerDrive(seen.drive, seen.map, observation, moved(0, 0, 1.57) * elsewhere));
}

}  // namespace
}  // namespace estancia
