// A live source that gives what a test feeds it, frame by frame, and ends when the test ends it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <deque>
#include <mutex>
#include <utility>

#include "estancia/sequences/sequence.hpp"
#include "estancia/sources/frame_source.hpp"

namespace estancia::test {

class FedSource : public FrameSource {
 public:
  /// With the depth, the camera and the poses of `like`.
  explicit FedSource(const Sequence& like, bool poses = true)
      : depth_(like.hasDepth()), poses_(poses), camera_(like.intrinsics()) {}

  void feed(LiveFrame frame) {
    const std::lock_guard lock(mutex_);
    frame.arrived = std::chrono::steady_clock::now();
    frames_.push_back(std::move(frame));
    changed_.notify_all();
  }
  void feed(const Sequence& drive, std::size_t i) {
    LiveFrame live;
    live.frame = drive.frame(i);
    if (!poses_) live.frame.pose.reset();
    live.image = drive.image(i);
    if (depth_) live.depth = drive.depth(i);
    feed(std::move(live));
  }
  void end() {
    const std::lock_guard lock(mutex_);
    isOver_ = true;
    changed_.notify_all();
  }

  std::string name() const override { return "fed"; }
  /// Or a slow machine would leave out what the frames show.
  bool isOnDemand() const override { return true; }
  std::optional<LiveFrame> newest(std::chrono::milliseconds patience) override {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, patience, [this] { return !frames_.empty() || isOver_; });
    if (frames_.empty()) return std::nullopt;
    LiveFrame frame = std::move(frames_.front());
    frames_.pop_front();
    return frame;
  }
  bool ended() const override {
    const std::lock_guard lock(mutex_);
    return isOver_ && frames_.empty();
  }
  bool hasDepth() const override { return depth_; }
  bool hasPoses() const override { return poses_; }
  std::optional<CameraIntrinsics> intrinsics() const override { return camera_; }

 private:
  bool depth_, poses_;
  std::optional<CameraIntrinsics> camera_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<LiveFrame> frames_;
  bool isOver_ = false;
};

}  // namespace estancia::test
