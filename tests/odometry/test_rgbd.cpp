// SPDX-License-Identifier: Apache-2.0
#include "estancia/odometry/rgbd.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "estancia/core/error.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "support/errors.hpp"
#include "support/numbers.hpp"
#include "support/room.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

Caught refusal(const Sequence& sequence, const RgbdOptions& options = {}) {
  return caught([&] { trackRgbd(sequence, options); });
}

std::vector<std::size_t> lostFrames(const RgbdTrajectory& trajectory) {
  std::vector<std::size_t> frames;
  for (const auto& lost : trajectory.lost) {
    frames.push_back(lost.frame);
    EXPECT_FALSE(trajectory.poses[lost.frame]) << lost.frame;
    EXPECT_NE(lost.why, "");
  }
  return frames;
}

std::vector<std::size_t> bridgedFrames(const RgbdTrajectory& trajectory) {
  std::vector<std::size_t> frames;
  for (const auto& bridged : trajectory.bridged) {
    frames.push_back(bridged.frame);
    EXPECT_TRUE(trajectory.poses[bridged.frame]) << bridged.frame;
    EXPECT_NE(bridged.why, "");
  }
  return frames;
}

class Terms : public testing::TestWithParam<std::string> {};

TEST_P(Terms, ACameraIsFollowedThroughARoom) {
  const Drive drive(turnAround(40, -20));
  const auto trajectory = trackRgbd(drive, {.term = GetParam()});
  EXPECT_THAT(lostFrames(trajectory), IsEmpty());
  ASSERT_EQ(trajectory.poses.size(), 20U);
  EXPECT_LT(errorOf(trajectory, drive), 0.02);
  EXPECT_GT(trajectory.keyframes.size(), 2U);
  EXPECT_LT(trajectory.keyframes.size(), 20U);
}

INSTANTIATE_TEST_SUITE_P(Rgbd, Terms, testing::Values("auto", "hybrid"),
                         [](const auto& term) { return term.param; });

TEST(Rgbd, TheMapBeginsAtTheFirstCameraWhichIsLevelAndLooksAlongX) {
  const auto trajectory = trackRgbd(Drive(turnAround(40, -35)));
  ASSERT_TRUE(trajectory.poses[0]);
  EXPECT_NEAR(distanceBetween(*trajectory.poses[0], {}), 0, 1e-9);
  EXPECT_NEAR(trajectory.poses[0]->forward()[0], 1, 1e-9);
  ASSERT_TRUE(trajectory.poses[4]);
  EXPECT_NEAR(trajectory.poses[4]->z, 0, 0.02);                 // the floor stays below
  EXPECT_GT(trajectory.poses[4]->forward()[1], std::sin(0.5));  // it turned left by 36°
}

TEST(Rgbd, LoopsTakeDriftAway) {
  const Drive drive(turnAround(30, 8), 1);
  const RgbdOptions options{.keyframeOverlap = 0.9};  // many keyframes, much drift
  RgbdOptions none = options;
  none.loopCandidates = 0;
  const auto drifting = trackRgbd(drive, none);
  const auto closed = trackRgbd(drive, options);
  EXPECT_THAT(drifting.loops, IsEmpty());
  ASSERT_FALSE(closed.loops.empty());
  EXPECT_LT(errorOf(closed, drive), errorOf(drifting, drive));
}

TEST(Rgbd, ThreadsChangeNoBit) {
  const Drive drive(turnAround(30, 4), 1);
  const RgbdOptions one{.minLoopFeatures = 15, .threads = 1}, four{.minLoopFeatures = 15, .threads = 4};
  const auto a = trackRgbd(drive, one, wordsByHeading(drive)),
             b = trackRgbd(drive, four, wordsByHeading(drive));
  ASSERT_FALSE(a.loops.empty());
  EXPECT_EQ(a.loops, b.loops);
  for (std::size_t i = 0; i < a.poses.size(); ++i) {
    ASSERT_TRUE(a.poses[i] && b.poses[i]);
    EXPECT_EQ(a.poses[i]->x, b.poses[i]->x) << i;
    EXPECT_EQ(a.poses[i]->qz, b.poses[i]->qz) << i;
  }
}

TEST(Rgbd, BridgesNoLongerThanAnyoneKnowsTheMotion) {
  Drive drive(turnAround(240, -216));
  for (std::size_t i = 4; i < 14; ++i) drive.noDepthFile.insert(i);
  EXPECT_THAT(bridgedFrames(trackRgbd(drive)), testing::SizeIs(10));
  drive.noDepthFile.insert(14);
  const auto longer = trackRgbd(drive);
  EXPECT_THAT(longer.bridged, IsEmpty());
  EXPECT_THAT(lostFrames(longer), testing::SizeIs(11));
  EXPECT_LT(errorOf(longer, drive), 0.03) << "it goes on where it is";
}

TEST(Rgbd, FramesOfAnotherPlaceHaveNoPose) {
  std::vector<Pose> path = turnAround(120, -104);
  const std::vector<Pose> other = turnAround(120, -50);
  path.insert(path.begin() + 8, other.begin() + 60, other.begin() + 66);
  const Drive drive(path);
  const auto trajectory = trackRgbd(drive, {.minLoopFeatures = 12}, wordsByHeading(drive));
  EXPECT_THAT(lostFrames(trajectory), ElementsAre(8, 9, 10, 11, 12, 13));
  EXPECT_LT(errorOf(trajectory, drive), 0.02);
}

TEST(Rgbd, FramesWithoutUsableDepthAreNamedAndTheOthersTracked) {
  Drive drive(turnAround(60, -48));
  drive.noDepthFile = {3};
  drive.noDepthValues = {6};
  drive.covered = {8};
  const auto trajectory = trackRgbd(drive, {.minLoopFeatures = 12});
  EXPECT_THAT(bridgedFrames(trajectory), ElementsAre(3, 6, 8));
  EXPECT_LT(errorOf(trajectory, drive), 0.02);
}

TEST(Rgbd, ACameraCarriedAwayIsFoundByItsWordsWhereItWasBefore) {
  auto path = turnAround(40, -20);  // half a turn, and then back at the beginning
  const auto start = turnAround(80, -76);
  path.insert(path.end(), start.begin(), start.end());
  const Drive drive(path);
  const auto blind = trackRgbd(drive, {.minLoopFeatures = 12});
  EXPECT_THAT(lostFrames(blind), ElementsAre(20, 21, 22, 23));
  const auto found = trackRgbd(drive, {.minLoopFeatures = 12}, wordsByHeading(drive));
  EXPECT_THAT(lostFrames(found), IsEmpty());
  EXPECT_LT(errorOf(found, drive), 0.04);
}

TEST(Rgbd, DepthMayBeSmallerThanTheImage) {
  Drive drive(turnAround(60, -52));
  drive.shrink = 2;
  const auto trajectory = trackRgbd(drive);
  EXPECT_THAT(lostFrames(trajectory), IsEmpty());
  EXPECT_LT(errorOf(trajectory, drive), 0.06);  // a bare wall, and only 4,800 pixels
}

TEST(Rgbd, RefusesWhatCannotBeTracked) {
  Drive drive(turnAround(60, -57));
  drive.cutDepth = 40;
  EXPECT_THAT(refusal(drive), FailsWith(ErrorCode::insufficientData));
  drive.cutDepth = 1;
  EXPECT_FALSE(refusal(drive).code);
  drive.unit = 1000;  // millimeters taken for meters: all beyond the horizon
  EXPECT_THAT(refusal(drive), FailsWith(ErrorCode::insufficientData, "room", "--depth-scale"));
  drive.unit = 1;
  drive.noDepthFile = {0, 1, 2};
  EXPECT_THAT(refusal(drive), FailsWith(ErrorCode::insufficientData));
  drive.forgetCamera();
  EXPECT_THAT(refusal(drive), FailsWith(ErrorCode::invalidInput, "--intrinsics", "estancia check"));
  drive.depthKnown = false;
  EXPECT_THAT(refusal(drive), FailsWith(ErrorCode::invalidInput, "--poses"));
  EXPECT_THAT(refusal(Drive({})), FailsWith(ErrorCode::insufficientData));
}

TEST(Rgbd, RefusesOptionsOutOfRange) {
  const Drive drive({Pose{}});
  EXPECT_THAT(refusal(drive, {.term = "sonar"}), FailsWith(ErrorCode::unknownName));
  const RgbdOptions wrong[] = {{.maxWidth = 10},         {.maxDepth = std::nan("")}, {.keyframeOverlap = 1.5},
                               {.keyframeOverlap = 0.2}, {.minLoopFeatures = 3},     {.threads = -1}};
  for (const RgbdOptions& options : wrong)
    EXPECT_THAT(refusal(drive, options), FailsWith(ErrorCode::invalidOption)) << &options - wrong;
}

TEST(Rgbd, ARealKitchenWithoutLoops) {
  const auto folder = findData("sevenscenes_redkitchen");
  ESTANCIA_NEEDS(folder, "the data set sevenscenes_redkitchen is missing (ESTANCIA_DATA)");
  const auto kitchen = openSequence(*folder);
  const auto trajectory = trackRgbd(*kitchen);
  EXPECT_THAT(lostFrames(trajectory), IsEmpty());
  EXPECT_LT(errorOf(trajectory, *kitchen), 0.10);
}

}  // namespace
}  // namespace estancia::test
