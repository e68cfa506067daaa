// Tracking a drive with depth: through rooms, over gaps and loops, with a motion prior; and its graphs.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/odometry/rgbd.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "estancia/core/error.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/core/take_interrupt.hpp"
#include "estancia/odometry/keyframe_graph.hpp"
#include "estancia/odometry/pose_graph.hpp"
#include "estancia/odometry/prior.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "support/errors.hpp"
#include "support/numbers.hpp"
#include "support/room.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

using odometry::KeyframeGraph;
using odometry::optimizePoses;
using odometry::PoseGraphEdge;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

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
  EXPECT_THAT(bridgedFrames(trackRgbd(drive)), SizeIs(10));
  drive.noDepthFile.insert(14);
  const auto longer = trackRgbd(drive);
  EXPECT_THAT(longer.bridged, IsEmpty());
  EXPECT_THAT(lostFrames(longer), SizeIs(11));
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

TEST(Rgbd, StopsWhenAsked) {
  requestInterrupt();
  EXPECT_THAT(refusal(Drive(turnAround(60, -57))), FailsWith(ErrorCode::interrupted));
  EXPECT_TRUE(takeInterrupt());
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

/// A chain of keyframes, each a step ahead of the one before.
class Chain {
 public:
  explicit Chain(std::size_t length) {
    const Drive drive({Pose::planar(0, 0, 0)});
    view_ = odometry::viewOf(drive.image(0), drive.depth(0), *drive.intrinsics(), {}, "");
    for (std::size_t k = 0; k < length; ++k) append();
  }
  void append() {
    const cv::Affine3d ahead(cv::Vec3d(0, 0, 0.02), cv::Vec3d(0.1, 0, 0));
    const std::size_t k = keyframes_.size();
    keyframes_.add(k, view_, k == 0 ? cv::Affine3d::Identity() : keyframes_.pose(k - 1) * ahead, {});
    if (k > 0) graph.add({k, k - 1, ahead, 1e-4 * cv::Matx66d::eye()}, KeyframeGraph::Kind::tracked);
  }
  /// A loop of the latest keyframe that measures a distance of `off` [m] from the truth. Returns what moved.
  std::vector<std::size_t> close(std::size_t target, double off,
                                 KeyframeGraph::Kind kind = KeyframeGraph::Kind::loop) {
    std::vector<cv::Affine3d> before;
    for (std::size_t k = 0; k < keyframes_.size(); ++k) before.push_back(keyframes_.pose(k));
    const cv::Affine3d loop =
        before[target].inv() * before.back() * cv::Affine3d(cv::Vec3d(), cv::Vec3d(off, 0, 0));
    graph.add({before.size() - 1, target, loop, 1e-4 * cv::Matx66d::eye()}, kind);
    graph.optimize(keyframes_);
    std::vector<std::size_t> moved;
    for (std::size_t k = 0; k < before.size(); ++k)
      if (cv::norm(before[k].matrix - keyframes_.pose(k).matrix) > 1e-6) moved.push_back(k);
    return moved;
  }
  KeyframeGraph graph;

 private:
  odometry::Keyframes keyframes_{{}};
  odometry::FrameView view_;
};

TEST(KeyframeGraph, AShortLoopMovesWhatIsNearAndALongOneAll) {
  Chain chain(400);
  const auto near = chain.close(380, 0.05);
  ASSERT_FALSE(near.empty());
  EXPECT_GT(near.front(), 250U);
  EXPECT_EQ(near.back(), 399U);
  chain.append();
  EXPECT_GT(chain.close(5, 0.05).size(), 350U);
  chain.append();  // the way over the loop is short now
  EXPECT_LT(chain.close(6, 0.05).size(), 150U);
}

TEST(KeyframeGraph, KnowsWhatIsNearOverLoops) {
  Chain chain(20);
  EXPECT_THAT(chain.graph.around(19, 10), ElementsAre(18, 17));
  EXPECT_THAT(chain.graph.around(10, 3), ElementsAre(11, 9, 12));
  EXPECT_THAT(chain.graph.around(10, 10, 5, 11), ElementsAre(9, 8, 7, 6, 5));
  for (const auto& [target, off] : {std::pair(2U, 0.0), std::pair(9U, 3.0)}) {  // the latter contradicts all
    chain.close(target, off);
    EXPECT_THAT(chain.graph.around(19, 10), ElementsAre(2, 18, 3, 1, 17));
  }
  EXPECT_TRUE(chain.graph.connects(19, 2));
  EXPECT_FALSE(chain.graph.connects(19, 3));
}

TEST(KeyframeGraph, FallsIntoPartsWhereNothingWasAligned) {
  Chain chain(4);
  chain.graph.removeEdgesOf(3);
  chain.close(2, 0, KeyframeGraph::Kind::assumed);
  EXPECT_TRUE(chain.graph.isAlone(3));
  EXPECT_FALSE(chain.graph.isOverdetermined(3));
  EXPECT_THAT(chain.graph.parts(4), ElementsAre(0, 0, 0, 3));
  chain.append();
  chain.close(1, 0);
  EXPECT_THAT(chain.graph.parts(5), ElementsAre(0, 0, 0, 0, 0));
}

}  // namespace
}  // namespace estancia::test
