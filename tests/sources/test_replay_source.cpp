// Recordings as live frames: pace, drops, clocks that jump, frames that cannot be read.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/sources/replay_source.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <set>
#include <thread>

#include "estancia/map_file/map.hpp"
#include "estancia/sources/frame_source.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using namespace std::chrono_literals;
using test::FailsWith;

/// Counts what was decoded.
class Recording : public Sequence {
 public:
  explicit Recording(const std::vector<std::optional<double>>& times) {
    for (const auto& time : times) {
      Frame frame;
      frame.name = "frame " + std::to_string(frames_.size());
      frame.timestamp = time;
      frames_.push_back(frame);
    }
  }
  std::string name() const override { return "recording"; }
  std::size_t size() const override { return frames_.size(); }
  const Frame& frame(std::size_t i) const override { return frames_.at(i); }
  cv::Mat image(std::size_t i) const override {
    decoded.insert(i);
    if (broken.contains(i)) throw Error(ErrorCode::fileUnreadable, frames_[i].name + " is broken");
    return {4, 4, CV_8UC3, cv::Scalar()};
  }
  mutable std::set<std::size_t> decoded;
  std::set<std::size_t> broken;

 private:
  std::vector<Frame> frames_;
};

std::vector<std::optional<double>> evenly(std::size_t count, double period) {
  std::vector<std::optional<double>> times;
  for (std::size_t i = 0; i < count; ++i) times.emplace_back(100 + period * static_cast<double>(i));
  return times;
}

TEST(ReplaySource, DropsWhatNobodyTookInTimeAndDecodesOnlyTheRest) {
  auto recording = std::make_unique<Recording>(evenly(100, 0.01));
  const Recording& seen = *recording;
  ReplaySource source(std::move(recording));
  std::size_t taken = 0, dropped = 0, next = 0;
  while (!source.ended()) {
    const auto live = source.newest(1s);
    ASSERT_TRUE(live);
    ++taken;
    dropped += live->dropped;
    next += live->dropped;
    EXPECT_EQ(live->frame.name, "frame " + std::to_string(next++)) << "frames stay in order, and are counted";
    EXPECT_LE(live->arrived, std::chrono::steady_clock::now());
    if (taken < 3) std::this_thread::sleep_for(55ms);
  }
  EXPECT_EQ(taken + dropped, 100U);
  EXPECT_GE(dropped, 8U);
  EXPECT_EQ(seen.decoded.size(), taken);
}

TEST(ReplaySource, GivesAllFramesAtRateZero) {
  ReplaySource source(std::make_unique<Recording>(evenly(50, 3600)), {.rate = 0});
  for (std::size_t i = 0; i < 50; ++i) {
    const auto live = source.newest(0ms);
    ASSERT_TRUE(live) << i;
    EXPECT_EQ(live->dropped, 0U);
  }
  EXPECT_TRUE(source.ended());
  EXPECT_FALSE(source.newest(0ms));
}

TEST(ReplaySource, IsNotStalledByAClockThatJumpsOrStands) {
  std::vector<std::optional<double>> times = evenly(20, 0.1);
  times[3] = -1e6;
  for (std::size_t i = 5; i < 9; ++i) times[i] = 42;
  times[12] = 1e12;
  times[15] = std::nullopt;
  ReplaySource source(std::make_unique<Recording>(times), {.rate = 100});
  std::size_t count = 0;
  for (int i = 0; i < 200 && !source.ended(); ++i)
    if (const auto live = source.newest(100ms)) count += 1 + live->dropped;
  EXPECT_EQ(count, 20U);
}

TEST(ReplaySource, TellsOfFramesThatCannotBeReadAndGoesOn) {
  auto recording = std::make_unique<Recording>(evenly(3, 1));
  recording->broken = {1};
  ReplaySource source(std::move(recording), {.rate = 0});
  EXPECT_TRUE(source.newest(0ms));
  EXPECT_EQ(source.trouble(), "");
  EXPECT_FALSE(source.newest(0ms));
  EXPECT_NE(source.trouble(), "");
  EXPECT_EQ(source.unreadable(), 1U);
  EXPECT_TRUE(source.newest(0ms));
  EXPECT_EQ(source.trouble(), "");
}

TEST(ReplaySource, GoesOnBehindTheFramesOfAMap) {
  ReplaySource source(std::make_unique<Recording>(evenly(5, 1)), {.rate = 0});
  TopologicalMap map{Vocabulary({"word"})};
  for (const char* name : {"frame 0", "frame 2"}) {
    MappedFrame frame;
    frame.name = name;
    map.frames.push_back(frame);
  }
  EXPECT_TRUE(source.goOnAfter(map));
  EXPECT_EQ(source.newest(0ms)->frame.name, "frame 3");
  map.frames.front().name = "another drive";
  EXPECT_FALSE(source.goOnAfter(map));
  EXPECT_EQ(source.newest(0ms)->frame.name, "frame 0");
}

TEST(OpenSource, SaysWhatIsNoSource) {
  EXPECT_THAT([] { makeFrameSource("/nowhere/at/all"); }, FailsWith(ErrorCode::fileNotFound));
  const test::ScratchFolder folder;
  test::writeFile(folder / "a.labels", "no words");
  EXPECT_THAT([&] { makeFrameSource(folder / "a.labels"); }, FailsWith(ErrorCode::unsupportedFile));
}

TEST(OpenSource, RefusesOptionsThatWouldDoNothing) {
  const auto refuses = [](const char* source, const FrameSourceOptions& options) {
    EXPECT_THAT([&] { makeFrameSource(source, options); }, FailsWith(ErrorCode::invalidOption)) << source;
  };
  FrameSourceOptions fast, depth, image, poses, backwards;
  fast.replay.rate = 2;
  depth.sequence.depthTopic = "/depth";
  image.sequence.imageTopic = "/image";
  poses.sequence.poses = "poses.txt";
  backwards.replay.rate = -1;
  for (const char* source : {"0", "http://127.0.0.1:9/video", "ros2:/image"})
    for (const FrameSourceOptions& options : {fast, poses, image}) refuses(source, options);
  refuses("0", depth);
  const test::ScratchFolder folder;
  cv::imwrite(folder / "a.png", cv::Mat(8, 8, CV_8U, 100));
  refuses(folder.path().c_str(), depth);
  refuses(folder.path().c_str(), backwards);
}

}  // namespace
}  // namespace estancia
