// The live page in a browser, on a robot that maps a rendered home (home_a) meanwhile.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "estancia/labelers/recorded_labeler.hpp"
#include "estancia/live/live_loop.hpp"
#include "estancia/readers/home_truth.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "estancia/sources/replay_source.hpp"
#include "site/browser.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

/// Frames of a drive, in any order and as often as wanted, each with a name of its own.
class Stretch final : public Sequence {
 public:
  /// `prefix` and a number are put before the names where it is not empty. Without time stamps, which would
  /// not be in order.
  Stretch(std::shared_ptr<const Sequence> drive, std::vector<std::size_t> indices, const std::string& prefix)
      : drive_(std::move(drive)), indices_(std::move(indices)) {
    intrinsics_ = drive_->intrinsics();
    for (const std::size_t i : indices_) {
      frames_.push_back(drive_->frame(i));
      frames_.back().timestamp.reset();
      if (!prefix.empty())
        frames_.back().name = fmt::format("{} {}/{}", prefix, frames_.size(), frames_.back().name);
    }
  }
  std::string name() const override { return drive_->name(); }
  std::size_t size() const override { return frames_.size(); }
  const Frame& frame(std::size_t i) const override { return frames_.at(i); }
  cv::Mat image(std::size_t i) const override { return drive_->image(indices_.at(i)); }
  bool hasDepth() const override { return drive_->hasDepth(); }
  cv::Mat depth(std::size_t i) const override { return drive_->depth(indices_.at(i)); }

 private:
  std::shared_ptr<const Sequence> drive_;
  std::vector<std::size_t> indices_;
  std::vector<Frame> frames_;
};

/// A drive that is played five times as fast as it was recorded. On its way the robot stands still, its
/// camera goes on, until the test lets it go on: a slow browser finds it there, too.
class DriveWithARest final : public FrameSource {
 public:
  DriveWithARest(const std::shared_ptr<const Sequence>& drive, std::size_t rest) {
    std::vector<std::size_t> before(rest), after(drive->size() - rest);
    std::iota(before.begin(), before.end(), std::size_t{0});
    std::iota(after.begin(), after.end(), rest);
    constexpr std::size_t longest = 25 * 120;  // two minutes; the browser will not come after that
    legs_ = {play(drive, before, ""), play(drive, std::vector(longest, rest - 1), "still"),
             play(drive, after, "")};
  }
  void goOn() { goesOn_ = true; }

  std::string name() const override { return legs_[0]->name(); }
  std::optional<LiveFrame> newest(std::chrono::milliseconds patience) override {
    if (leg_ == 0 && legs_[0]->ended()) leg_ = 1;
    if (leg_ == 1 && (goesOn_ || legs_[1]->ended())) leg_ = 2;
    return legs_.at(leg_)->newest(patience);
  }
  bool ended() const override { return legs_[2]->ended(); }
  std::size_t unreadable() const override {
    return std::transform_reduce(legs_.begin(), legs_.end(), std::size_t{0}, std::plus<>(),
                                 [](const auto& leg) { return leg->unreadable(); });
  }
  std::string trouble() const override { return legs_.at(leg_)->trouble(); }
  bool hasDepth() const override { return legs_[0]->hasDepth(); }
  bool hasPoses() const override { return legs_[0]->hasPoses(); }
  std::optional<CameraIntrinsics> intrinsics() const override { return legs_[0]->intrinsics(); }

 private:
  static std::unique_ptr<ReplaySource> play(const std::shared_ptr<const Sequence>& drive,
                                            std::vector<std::size_t> indices, const std::string& prefix) {
    return std::make_unique<ReplaySource>(std::make_unique<Stretch>(drive, std::move(indices), prefix),
                                          ReplayOptions{.rate = 5, .framesPerSecond = 5});
  }

  std::array<std::unique_ptr<ReplaySource>, 3> legs_;
  std::atomic<std::size_t> leg_ = 0;
  std::atomic<bool> goesOn_ = false;
};

/// "coffee table".
std::string wordOf(const io::HomeInstance& thing) {
  std::string word = thing.category;
  std::ranges::replace(word, '_', ' ');
  return word;
}

/// The truth as words: the things that an image shows, by their pixels; no network is needed.
DescriptorSequence visibleThings(const io::HomeTruth& truth, const Sequence& drive) {
  std::map<std::string, std::size_t> labelOf;  // each word's
  for (const io::HomeInstance& thing : truth.instances) labelOf[wordOf(thing)] = 0;
  std::vector<std::string> labels;
  for (auto& [word, label] : labelOf) {
    label = labels.size();
    labels.push_back(word);
  }
  std::map<int, std::size_t> labelOfThing;
  for (const io::HomeInstance& thing : truth.instances) labelOfThing[thing.id] = labelOf[wordOf(thing)];

  DescriptorSequence result{Vocabulary(labels), "truth", {}, DescriptorMatrix(labels.size())};
  for (std::size_t i = 0; i < drive.size(); ++i) {
    LexicalDescriptor words(labels.size(), 1);  // at least one pixel a label: no word is impossible
    auto pixels = static_cast<float>(labels.size());
    if (const auto visible = truth.visible.find(drive.frame(i).name); visible != truth.visible.end())
      for (const io::VisibleInstance& seen : visible->second) {
        words[labelOfThing.at(seen.id)] += static_cast<float>(seen.pixels);
        pixels += static_cast<float>(seen.pixels);
      }
    for (float& word : words) word /= pixels;
    result.frames.push_back(drive.frame(i));
    result.descriptors.append(words);
  }
  return result;
}

std::size_t named(const WorldMap& world, const std::string& name) {
  return static_cast<std::size_t>(std::ranges::count(world.areas, name, &WorldArea::givenName));
}

TEST(PageOfADrive, ShowsItGrowAndKeepsANameThatIsGivenMeanwhile) {
  const auto home = test::findData("home_a");
  ESTANCIA_NEEDS(home, "home_a is missing");
  const std::string name = "Ana's <lounge>";  // the name in page.mjs
  const std::shared_ptr<const Sequence> drive = openSequence(*home / "day");
  RecordedLabeler labeler(visibleThings(io::readHomeTruth(*home / "day"), *drive));
  const test::ScratchFolder folder;
  const auto file = folder / "home.estancia";
  constexpr std::size_t rest = 110;  // in the corridor, after the living room and the bedroom
  auto source = std::make_unique<DriveWithARest>(drive, rest);
  DriveWithARest& robot = *source;
  LiveLoop live(std::move(source), labeler, file);
  auto server = std::make_unique<PageServer>(live, test::optionsAt());
  auto browser = test::browse(*server, 390, "drive");
  if (!browser.valid()) GTEST_SKIP() << "needs the tests' npm packages";
  auto run = std::async(std::launch::async, [&live] { live.run(); });
  while (browser.wait_for(std::chrono::milliseconds(100)) != std::future_status::ready)
    if (const auto world = live.world(); world && named(*world, name) > 0) robot.goOn();
  const test::CommandResult result = browser.get();
  EXPECT_EQ(result.exitCode, 0) << result.out << result.err;
  live.stop();  // where the browser did not see the end
  EXPECT_NO_THROW(run.get());
  server.reset();

  const LiveStatus last = live.status();
  EXPECT_EQ(last.state, "ended");
  EXPECT_EQ(last.failed, 0U);
  EXPECT_THAT(last.troubles, testing::IsEmpty());
  const WorldMap kept = readWorld(file);
  EXPECT_EQ(named(kept, name), 1U);
  EXPECT_EQ(kept.places.frames.size(), last.frames);
  EXPECT_EQ(kept.places.frames.back().name, drive->frame(drive->size() - 1).name) << "it drove to the end";
}

}  // namespace
}  // namespace estancia
