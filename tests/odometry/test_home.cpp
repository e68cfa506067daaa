// A furnished home: a passage through a door, with a bare wall while the camera turns.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <opencv2/core.hpp>

#include "support/room.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

using testing::IsEmpty;

/// Every n-th frame of a part of a sequence, with a Kinect's noise if wanted.
class Part : public Sequence {
 public:
  Part(std::unique_ptr<Sequence> whole, std::size_t first, std::size_t frames, std::size_t every,
       double noise)
      : whole_(std::move(whole)), first_(first), frames_(frames), every_(every), noise_(noise) {
    intrinsics_ = whole_->intrinsics();
  }
  std::string name() const override { return whole_->name(); }
  std::size_t size() const override { return frames_; }
  const Frame& frame(std::size_t i) const override { return whole_->frame(first_ + every_ * i); }
  cv::Mat image(std::size_t i) const override { return whole_->image(first_ + every_ * i); }
  bool hasDepth() const override { return true; }
  cv::Mat depth(std::size_t i) const override {
    const cv::Mat exact = whole_->depth(first_ + every_ * i);
    cv::Mat random(exact.size(), CV_32F);
    cv::RNG(i + 1).fill(random, cv::RNG::NORMAL, 0, noise_);
    return exact + exact.mul(exact).mul(random);
  }

 private:
  std::unique_ptr<Sequence> whole_;
  std::size_t first_, frames_, every_;
  double noise_;
};

class Home : public testing::Test {
 protected:
  void SetUp() override {
    const auto folder = findData("home_a");
    ESTANCIA_NEEDS(folder, "the data set home_a is missing (ESTANCIA_DATA)");
    day_ = *folder / "day";
  }
  Part part(std::size_t every, double noise) const {
    return {openSequence(day_), 60, 60 / every, every, noise};
  }
  std::filesystem::path day_;
};

TEST_F(Home, IsFollowedWithAKinectsNoise) {
  const Part drive = part(1, 0.0012);
  const auto trajectory = trackRgbd(drive);
  EXPECT_THAT(trajectory.lost, IsEmpty());
  EXPECT_LT(errorOf(trajectory, drive), 0.05);
}

}  // namespace
}  // namespace estancia::test
