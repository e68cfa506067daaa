// Replay: a recorded sequence as live frames, at the pace of its time stamps.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <memory>
#include <mutex>

#include "estancia/sequences/sequence.hpp"
#include "estancia/sources/frame_source.hpp"

namespace estancia {

/// The frames of a sequence when they are due. Only those that are taken are decoded. Invariant: `next_` is
/// the first frame that was neither given nor dropped, due at `due_`. Life cycle: newest() is called by one
/// thread until ended(); `mutex_` guards what other threads ask.
class ReplaySource : public FrameSource {
 public:
  /// Throws Error (invalidOption).
  explicit ReplaySource(std::unique_ptr<Sequence> sequence, const ReplayOptions& options = {});

  std::string name() const override { return sequence_->name(); }
  std::optional<LiveFrame> newest(std::chrono::milliseconds patience) override;
  bool isOnDemand() const override { return options_.rate <= 0; }
  std::vector<std::string> warnings() const override { return sequence_->warnings(); }
  std::size_t unreadable() const override { return unreadable_; }
  bool goOnAfter(const TopologicalMap& map) override;
  DriveStart driveStart() const override { return driveStartOf(*sequence_); }
  bool ended() const override { return next_ >= sequence_->size(); }
  std::string trouble() const override;
  bool hasDepth() const override { return sequence_->hasDepth() && sequence_->intrinsics(); }
  bool hasPoses() const override { return hasPoses_; }
  std::optional<CameraIntrinsics> intrinsics() const override { return sequence_->intrinsics(); }

 private:
  using Clock = std::chrono::steady_clock;
  double pauseBefore(std::size_t frame) const;
  std::optional<LiveFrame> read(std::size_t frame);
  void say(const std::string& trouble);

  std::unique_ptr<Sequence> sequence_;
  ReplayOptions options_;
  /// Pause between frames without usable time stamps [s].
  double period_;
  bool hasPoses_ = false;
  std::atomic<std::size_t> next_ = 0, unreadable_ = 0;
  std::size_t dropped_ = 0;  ///< since the frame that was taken last
  bool started_ = false;
  Clock::time_point due_;  ///< due time of next_
  mutable std::mutex mutex_;
  std::string trouble_;
};

}  // namespace estancia
