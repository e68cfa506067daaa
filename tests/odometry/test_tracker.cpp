// Tracking frame by frame: what is known when, going on after a crash, and input that is wrong.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/odometry/tracker.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <map>
#include <opencv2/core.hpp>

#include "estancia/core/error.hpp"
#include "estancia/core/pose.hpp"
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

TEST(RgbdTracker, ACameraThatNeverMovesHasOneKeyframe) {
  const Drive drive(std::vector<Pose>(30, Pose::planar(0.3, 0.2, 0.5)), 1);
  const auto trajectory = trackRgbd(drive);
  EXPECT_THAT(trajectory.keyframes, ElementsAre(0));
  EXPECT_EQ(trajectory.corrections, 0U);
  EXPECT_THAT(trajectory.lost, IsEmpty());
  EXPECT_LT(errorOf(trajectory, drive), 0.005);
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
    if (i % 7 == 5) broken = RgbdTracker::restore(camera, manyKeyframes, {}, store.state());
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

TEST(RgbdTracker, RefusesADamagedState) {
  const Drive drive(turnAround(30, -26));
  const CameraIntrinsics camera = *drive.intrinsics();
  RgbdTracker tracker(camera);
  for (std::size_t i = 0; i < drive.size(); ++i) addFrame(tracker, drive, i);
  using State = RgbdTracker::State;
  const State good = tracker.save();
  const auto refusal = [&](const State& state, const RgbdOptions& options = {}) {
    return caught([&] { RgbdTracker::restore(camera, options, {}, state); });
  };
  EXPECT_FALSE(refusal(good).code);
  EXPECT_FALSE(refusal(good, {.threads = 1}).code);
  EXPECT_THAT(refusal(good, {.maxDepth = 5}), FailsWith(ErrorCode::mismatch));
  State state = good;
  state.frames.pop_back();
  EXPECT_THAT(refusal(state), FailsWith(ErrorCode::malformedFile));
  state = good;
  for (std::string* row : {&state.head, &state.keyframes.back().bytes, &state.frames.back().bytes}) {
    const std::string whole = *row;
    *row += "more";
    EXPECT_THAT(refusal(state), FailsWith(ErrorCode::malformedFile));
    for (std::size_t at = 0; at < whole.size(); at += at < 64 || at + 800 > whole.size() ? 5 : 331) {
      *row = whole.substr(0, at);
      EXPECT_THAT(refusal(state), FailsWith(ErrorCode::truncatedFile)) << at;
      *row = whole;
      row->replace(at, std::min<std::size_t>(8, row->size() - at), 8, '\xff');
      const auto code = refusal(state).code.value_or(ErrorCode::malformedFile);
      EXPECT_THAT(code,
                  testing::AnyOf(ErrorCode::malformedFile, ErrorCode::truncatedFile, ErrorCode::mismatch))
          << at;
    }
    *row = whole;
  }
  void (*const damages[])(State&) = {[](State& s) { s.head[0] = 9; },
                                     [](State& s) { s.keyframes.back().bytes.replace(200, 4, "hurt"); },
                                     [](State& s) { s.frames.back().bytes[1] = 77; }};  // its keyframe
  for (const auto damage : damages) {
    state = good;
    damage(state);
    EXPECT_THAT(refusal(state), FailsWith(ErrorCode::malformedFile));
  }
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
  const cv::Mat empty;
  const std::pair<cv::Mat, cv::Mat> bad[] = {{empty, depth},
                                             {image, empty},
                                             {cv::Mat(120, 160, CV_8U), depth},
                                             {image, cv::Mat(120, 160, CV_16U)},
                                             {image, cv::Mat(120, 160, CV_32F, cv::Scalar(nan))},
                                             {image, cv::Mat(120, 160, CV_32F, cv::Scalar(-1))},
                                             {image, cv::Mat(160, 120, CV_32F, cv::Scalar(2))},
                                             {cv::Mat(90, 160, CV_8UC3), cv::Mat(90, 160, CV_32F)}};
  for (const auto& [bgr, meters] : bad) EXPECT_NE(why(bgr, meters), "");
  EXPECT_EQ(tracker.skip("no such file", {}).why, "no such file");
  for (std::size_t i = 1; i < drive.size(); ++i) EXPECT_EQ(addFrame(tracker, drive, i).why, "") << i;
  EXPECT_EQ(tracker.size(), drive.size() + 9);
  EXPECT_TRUE(tracker.at(4).pose) << "bridged";
}

TEST(RgbdTracker, NeedsACamera) {
  for (const CameraIntrinsics& camera :
       {CameraIntrinsics{}, CameraIntrinsics{160, 120, 140, std::nan(""), 80, 60}})
    EXPECT_THAT([&] { RgbdTracker tracker(camera); }, FailsWith(ErrorCode::invalidInput));
  const RgbdOptions wrong{.minCorrection = -1};
  EXPECT_THAT(
      [&] {
        RgbdTracker tracker({160, 120, 140, 140, 80, 60}, wrong);
      },
      FailsWith(ErrorCode::invalidOption));
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
