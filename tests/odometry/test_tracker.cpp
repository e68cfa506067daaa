// Tracking frame by frame: what is known when, going on after a crash, and input that is wrong.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/odometry/tracker.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <map>
#include <opencv2/imgproc.hpp>

#include "estancia/core/error.hpp"
#include "estancia/core/rigid.hpp"
#include "support/errors.hpp"
#include "support/numbers.hpp"
#include "support/room.hpp"

namespace estancia::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

FrameFacts factsOf(const Sequence& drive, std::size_t i, const FrameWords& words = {}) {
  FrameFacts facts{drive.frame(i).name, drive.frame(i).timestamp, std::nullopt, {}};
  if (words.describe) facts.words = [&words, i] { return words.describe(i); };
  return facts;
}

RgbdTracker::Placement addFrame(RgbdTracker& tracker, const Sequence& drive, std::size_t i,
                                const FrameWords& words = {}) {
  return tracker.add(drive.image(i), drive.depth(i), factsOf(drive, i, words));
}

bool operator==(const Pose& a, const Pose& b) {
  return a.x == b.x && a.y == b.y && a.z == b.z && a.qx == b.qx && a.qy == b.qy && a.qz == b.qz &&
         a.qw == b.qw;
}

bool areSame(const std::optional<Pose>& a, const std::optional<Pose>& b) {
  return a.has_value() == b.has_value() && (!a || *a == *b);
}

/// Much drift and some loops.
const RgbdOptions manyKeyframes{.keyframeOverlap = 0.9, .minLoopFeatures = 15};

TEST(RgbdTracker, GivesEachFrameItsPoseAtOnce) {
  const Drive drive(turnAround(40, -20));
  RgbdTracker tracker(*drive.intrinsics());
  for (std::size_t i = 0; i < drive.size(); ++i) {
    const auto placement = addFrame(tracker, drive, i);
    EXPECT_EQ(placement.why, "");
    ASSERT_TRUE(placement.pose) << i;
    EXPECT_TRUE(areSame(tracker.at(i).pose, placement.pose));
  }
  EXPECT_EQ(tracker.size(), drive.size());
  tracker.settle();
  const auto alone = tracker.trajectory(), whole = trackRgbd(drive);
  for (std::size_t i = 0; i < drive.size(); ++i)
    EXPECT_TRUE(areSame(alone.poses[i], whole.poses[i])) << "trackRgbd() is a loop over it";
  EXPECT_EQ(alone.keyframes, whole.keyframes);
  EXPECT_EQ(whole.online.size(), drive.size());
}

TEST(RgbdTracker, KnowsMotionsAlsoInAPartWithoutAPlace) {
  std::vector<Pose> path = turnAround(40, -28), far = turnAround(40);
  path.insert(path.end(), far.begin() + 22, far.begin() + 26);  // it is carried
  Drive drive(path);
  drive.noDepthValues = {3};
  RgbdTracker tracker(*drive.intrinsics());
  for (std::size_t i = 0; i < drive.size(); ++i) addFrame(tracker, drive, i);
  ASSERT_FALSE(tracker.at(14).pose);
  const auto motion = tracker.motion(13, 15);
  ASSERT_TRUE(motion);
  const Pose truth = poseOf(rigidOf(path[13]).inv() * rigidOf(path[15]));
  EXPECT_LT(distanceBetween(*motion, truth), 0.02);
  EXPECT_TRUE(tracker.motion(0, 11));
  EXPECT_FALSE(tracker.motion(11, 15)) << "of another part";
  EXPECT_FALSE(tracker.motion(3, 3)) << "not tracked";
  EXPECT_FALSE(tracker.motion(0, 16)) << "not there yet";
}

TEST(RgbdTracker, TellsByItsRevisionWhenEarlierPosesChange) {
  const Drive drive(turnAround(30, 8), 1);
  RgbdOptions options = manyKeyframes;
  options.minCorrection = 0.002;
  const FrameWords words = wordsByHeading(drive);
  RgbdTracker tracker(*drive.intrinsics(), options);
  std::vector<std::optional<Pose>> known;
  std::uint64_t revision = 0;
  std::size_t corrected = 0;
  for (std::size_t i = 0; i < drive.size(); ++i) {
    addFrame(tracker, drive, i, words);
    bool isSame = true;
    for (std::size_t j = 0; j < i; ++j) {
      isSame = isSame && areSame(tracker.at(j).pose, known[j]);
      known[j] = tracker.at(j).pose;
    }
    EXPECT_EQ(isSame, tracker.revision() == revision) << i;
    corrected += tracker.revision() != revision ? 1 : 0;
    revision = tracker.revision();
    known.push_back(tracker.at(i).pose);
  }
  EXPECT_GE(corrected, 1U);
  EXPECT_LT(corrected, drive.size() / 2);
  tracker.settle();
  const std::uint64_t settled = tracker.revision();
  tracker.settle();
  EXPECT_EQ(tracker.revision(), settled);
  EXPECT_LT(errorOf(tracker.trajectory(), drive), 0.03);
}

TEST(RgbdTracker, ACameraThatComesBackNeedsNoMoreKeyframes) {
  const Drive once(turnAround(40)), thrice(turnAround(40, 80));
  const auto first = trackRgbd(once), all = trackRgbd(thrice);
  EXPECT_LE(all.keyframes.size(), first.keyframes.size() + 3);
  EXPECT_LT(errorOf(all, thrice), 0.02);
}

TEST(RgbdTracker, ACameraThatNeverMovesHasOneKeyframe) {
  const Drive drive(std::vector<Pose>(30, Pose::planar(0.3, 0.2, 0.5)), 1);
  const auto trajectory = trackRgbd(drive);
  EXPECT_THAT(trajectory.keyframes, ElementsAre(0));
  EXPECT_EQ(trajectory.corrections, 0U);
  EXPECT_THAT(trajectory.lost, IsEmpty());
  EXPECT_LT(errorOf(trajectory, drive), 0.005);
}

TEST(RgbdTracker, ACameraInTheDarkFillsNoMemory) {
  Drive drive(turnAround(60, -20));
  for (std::size_t i = 10; i < 34; ++i) drive.covered.insert(i);
  Drive seen(turnAround(60, -20));
  for (std::size_t i = 10; i < 34; ++i) seen.noDepthValues.insert(i);
  const auto dark = trackRgbd(drive), none = trackRgbd(seen);
  EXPECT_LE(dark.keyframes.size(), none.keyframes.size() + 2);
  EXPECT_GE(dark.lost.size(), 24U);
}

/// The rows as a file would keep them.
class Store {
 public:
  void write(const RgbdTracker::State& state) {
    head_ = state.head;
    for (const auto& row : state.keyframes) keyframes_[row.number] = row.bytes;
    for (const auto& row : state.frames) frames_[row.number] = row.bytes;
  }
  RgbdTracker::State state() const {
    RgbdTracker::State state{head_, {}, {}};
    for (const auto& [number, bytes] : keyframes_) state.keyframes.push_back({number, bytes});
    for (const auto& [number, bytes] : frames_) state.frames.push_back({number, bytes});
    return state;
  }

 private:
  std::string head_;
  std::map<std::uint64_t, std::string> keyframes_, frames_;
};

/// A drive with all that can go wrong: without depth, dark, with a jump, and with wheels that are set anew.
struct HardDrive {
  Drive drive{turnAround(30, 6), 1};
  FrameWords words = wordsByHeading(drive);
  MotionPrior wheels;

  HardDrive() {
    drive.noDepthValues = {5, 6};
    drive.covered = {12, 13, 14};
    std::vector<double> times;
    for (std::size_t i = 0; i < drive.size(); ++i) {
      times.push_back(static_cast<double>(i) + (i > 20 ? 7 : 0));
      wheels.push_back(*drive.frame(i).pose);
      if (i > 24) wheels.back()->x += 3;
    }
    drive.stamp(times);
  }
  void addTo(RgbdTracker& tracker, std::size_t i) const {
    auto facts = factsOf(drive, i, words);
    facts.prior = wheels[i];
    tracker.add(drive.image(i), drive.depth(i), facts);
  }
};

TEST(RgbdTracker, GoesOnAfterACrashAsIfNothingHadHappened) {
  const HardDrive hard;
  const CameraIntrinsics camera = *hard.drive.intrinsics();
  RgbdTracker unbroken(camera, manyKeyframes);
  std::optional<RgbdTracker> broken(std::in_place, camera, manyKeyframes);
  Store store;
  for (std::size_t i = 0; i < hard.drive.size(); ++i) {
    hard.addTo(unbroken, i);
    hard.addTo(*broken, i);
    store.write(broken->save());
    if (i % 3 != 1) broken = RgbdTracker::restore(camera, manyKeyframes, {}, store.state());
    ASSERT_EQ(broken->size(), i + 1);
    ASSERT_EQ(broken->revision(), unbroken.revision()) << i;
    for (std::size_t j = 0; j <= i; ++j) {
      ASSERT_TRUE(areSame(broken->at(j).pose, unbroken.at(j).pose)) << j << " after " << i;
      ASSERT_EQ(broken->at(j).why, unbroken.at(j).why);
    }
  }
  unbroken.settle(), broken->settle();
  const auto a = unbroken.trajectory(), b = broken->trajectory();
  for (std::size_t i = 0; i < a.poses.size(); ++i) EXPECT_TRUE(areSame(a.poses[i], b.poses[i])) << i;
  EXPECT_EQ(a.keyframes, b.keyframes);
  EXPECT_EQ(a.loops, b.loops);
  EXPECT_EQ(a.notes, b.notes);
  EXPECT_FALSE(a.loops.empty());
  EXPECT_THAT(b.online, testing::SizeIs(a.poses.size()));
}

TEST(RgbdTracker, SavesOnlyWhatChanged) {
  const Drive drive(turnAround(60, -50));
  RgbdTracker tracker(*drive.intrinsics());
  for (std::size_t i = 0; i < 5; ++i) addFrame(tracker, drive, i);
  EXPECT_THAT(tracker.save().frames, testing::SizeIs(5));
  const auto nothing = tracker.save();
  EXPECT_THAT(nothing.frames, IsEmpty());
  EXPECT_THAT(nothing.keyframes, IsEmpty());
  EXPECT_LT(nothing.head.size(), 100000U);
  addFrame(tracker, drive, 5);
  EXPECT_THAT(tracker.save().frames, testing::SizeIs(testing::Le(2)));
}

TEST(RgbdTracker, AnEmptyStateIsAState) {
  const CameraIntrinsics camera = *Drive({Pose{}}).intrinsics();
  RgbdTracker tracker = RgbdTracker::restore(camera, {}, {}, RgbdTracker(camera).save());
  EXPECT_EQ(tracker.size(), 0U);
  tracker.settle();
  EXPECT_THAT(tracker.trajectory().poses, IsEmpty());
  EXPECT_THAT(caught([&] { tracker.at(0); }), FailsWith(ErrorCode::invalidInput, "frame 0"));
}

TEST(RgbdTracker, RefusesADamagedState) {
  const Drive drive(turnAround(30, -26));
  const CameraIntrinsics camera = *drive.intrinsics();
  RgbdTracker tracker(camera);
  for (std::size_t i = 0; i < drive.size(); ++i) addFrame(tracker, drive, i);
  const RgbdTracker::State good = tracker.save();
  const auto refusal = [&](const RgbdTracker::State& state, const RgbdOptions& options = {}) {
    return caught([&] { RgbdTracker::restore(camera, options, {}, state); });
  };
  EXPECT_FALSE(refusal(good).code);
  EXPECT_THAT(refusal(good, {.maxDepth = 5}), FailsWith(ErrorCode::mismatch, "other options"));
  EXPECT_FALSE(refusal(good, {.threads = 1}).code);
  auto state = good;
  state.frames.pop_back();
  EXPECT_THAT(refusal(state), FailsWith(ErrorCode::malformedFile, "rows are missing"));
  state = good;
  state.head[0] = 9;
  EXPECT_THAT(refusal(state), FailsWith(ErrorCode::malformedFile, "version"));
  for (const std::size_t kept : {0, 3, 40, 300, 700, 5000}) {
    state = good;
    state.head.resize(kept);
    EXPECT_THAT(refusal(state), FailsWith(ErrorCode::truncatedFile)) << kept;
  }
  for (const std::size_t kept : {0, 3, 40, 300, 10000}) {
    state = good;
    state.keyframes.back().bytes.resize(kept);
    EXPECT_THAT(refusal(state), FailsWith(ErrorCode::truncatedFile)) << kept;
  }
  state = good;
  state.keyframes.back().bytes += "more";
  EXPECT_THAT(refusal(state), FailsWith(ErrorCode::malformedFile, "more"));
  state = good;
  state.keyframes.back().bytes.replace(200, 4, "hurt");
  EXPECT_THAT(refusal(state), FailsWith(ErrorCode::malformedFile, "image"));
  state = good;
  state.frames.back().bytes[1] = 77;  // its keyframe
  EXPECT_THAT(refusal(state), FailsWith(ErrorCode::malformedFile, "keyframe"));
}

TEST(RgbdTracker, FramesMayHaveAnySizeOfTheSameView) {
  const Drive drive(turnAround(60, -48));
  RgbdTracker tracker(*drive.intrinsics());
  for (std::size_t i = 0; i < drive.size(); ++i) {
    cv::Mat image, depth;
    const double scale[] = {1, 2, 0.75, 4};
    cv::resize(drive.image(i), image, {}, scale[i % 4], scale[i % 4], cv::INTER_LINEAR);
    cv::resize(drive.depth(i), depth, {}, scale[i % 3], scale[i % 3], cv::INTER_NEAREST);
    EXPECT_EQ(tracker.add(image, depth, factsOf(drive, i)).why, "") << i;
  }
  EXPECT_LT(errorOf(tracker.trajectory(), drive), 0.03);
}

TEST(RgbdTracker, FramesThatAreNoneAreNamedAndTheOthersTracked) {
  const Drive drive(turnAround(60, -48));
  RgbdTracker tracker(*drive.intrinsics());
  const auto nan = std::numeric_limits<float>::quiet_NaN();
  const auto why = [&](const cv::Mat& image, const cv::Mat& depth) {
    return tracker.add(image, depth, {.name = "bad"}).why;
  };
  addFrame(tracker, drive, 0);
  const cv::Mat image = drive.image(1), depth = drive.depth(1);
  EXPECT_THAT(why({}, depth), testing::HasSubstr("image"));
  EXPECT_THAT(why(image, {}), testing::HasSubstr("depth"));
  EXPECT_THAT(why(cv::Mat(120, 160, CV_8U), depth), testing::HasSubstr("BGR"));
  EXPECT_THAT(why(image, cv::Mat(120, 160, CV_16U)), testing::HasSubstr("meters"));
  EXPECT_THAT(why(image, cv::Mat(120, 160, CV_32F, cv::Scalar(nan))), testing::HasSubstr("0 of 19200"));
  EXPECT_THAT(why(image, cv::Mat(120, 160, CV_32F, cv::Scalar(-1))), testing::HasSubstr("0 of 19200"));
  EXPECT_THAT(why(image, cv::Mat(160, 120, CV_32F, cv::Scalar(2))), testing::HasSubstr("120 × 160"));
  EXPECT_THAT(why(cv::Mat(90, 160, CV_8UC3), cv::Mat(90, 160, CV_32F)), testing::HasSubstr("intrinsics"));
  EXPECT_EQ(tracker.skip("no such file", {}).why, "no such file");
  for (std::size_t i = 1; i < drive.size(); ++i) EXPECT_EQ(addFrame(tracker, drive, i).why, "") << i;
  EXPECT_EQ(tracker.size(), drive.size() + 9);
  EXPECT_TRUE(tracker.at(4).pose) << "bridged";
}

TEST(RgbdTracker, NeedsACamera) {
  EXPECT_THAT(caught([] { RgbdTracker({}); }), FailsWith(ErrorCode::invalidInput, "intrinsics"));
  EXPECT_THAT(caught([] {
                RgbdTracker({160, 120, 140, std::nan(""), 80, 60});
              }),
              FailsWith(ErrorCode::invalidInput, "intrinsics"));
  EXPECT_THAT(caught([] {
                RgbdTracker({160, 120, 140, 140, 80, 60}, {.minCorrection = -1});
              }),
              FailsWith(ErrorCode::invalidOption, "min-correction"));
}

TEST(RgbdTracker, TimeStampsMayGoBack) {
  Drive drive(turnAround(60, -52));
  const double nan = std::nan("");
  drive.stamp({100, 100.1, 50, 50.1, nan, 50.2, 50.1, 50.2});
  const auto trajectory = trackRgbd(drive);
  EXPECT_THAT(trajectory.lost, IsEmpty());
  EXPECT_THAT(trajectory.notes, ElementsAre("time stamps go back by 50.1 s before frame 2"));
  EXPECT_LT(errorOf(trajectory, drive), 0.02);
}

TEST(RgbdTracker, APriorThatJumpsHarmsNothing) {
  Drive drive(turnAround(40, -20));
  MotionPrior jumping;
  for (std::size_t i = 0; i < drive.size(); ++i) {
    jumping.push_back(*drive.frame(i).pose);
    if (i > 6) jumping.back()->x += 5;
    if (i > 13) jumping.back()->y -= 300;
    if (i % 5 == 4) jumping.back()->x = std::nan("");
  }
  drive.noDepthValues = {3, 10};
  const auto trajectory = trackRgbd(drive, {}, {}, Progress::none(), jumping);
  EXPECT_THAT(trajectory.lost, IsEmpty());
  EXPECT_LT(errorOf(trajectory, drive), 0.02);
}

}  // namespace
}  // namespace estancia::test
