// Altered drive: a sequence with fewer frames, with the noise of a depth camera, or with wheel odometry.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "estancia/sequences/sequence.hpp"

namespace estancia::experiments {

struct DriveAlteration {
  /// Only every so many-th frame, ≥ 1.
  std::size_t every = 1;
  /// k of σ(z) = k z² [1/m], the deviation of a depth z, of every pixel by itself. A Kinect's is 0.0012 to
  /// 0.0014 (Khoshelham and Elberink 2012).
  double noise = 0;
  /// Deviations of what wheels measure of each step: of its length [%], and of its turn about the vertical
  /// axis of a level camera [degrees]; both 0: no wheels.
  double wheelShift = 0, wheelTurn = 0;
  std::uint64_t seed = 1;
};

/// Reads its frames from `drive`. The noise of a frame depends only on the seed and the frame's number in
/// `drive`.
class AlteredDrive : public Sequence {
 public:
  AlteredDrive(std::shared_ptr<const Sequence> drive, const DriveAlteration& alteration);

  std::string name() const override { return drive_->name(); }
  std::size_t size() const override;
  const Frame& frame(std::size_t i) const override { return drive_->frame(original(i)); }
  cv::Mat image(std::size_t i) const override { return drive_->image(original(i)); }
  std::string fingerprint(std::size_t i) const override { return drive_->fingerprint(original(i)); }
  bool hasDepth() const override { return drive_->hasDepth(); }
  cv::Mat depth(std::size_t i) const override;
  std::optional<double> depthTimestamp(std::size_t i) const override {
    return drive_->depthTimestamp(original(i));
  }

  /// T_odom_camera of every frame as wheels have it: the steps of the true poses with the alteration's
  /// deviations, added up. Nothing for frames without a pose; empty without wheels.
  std::vector<std::optional<Pose>> wheels() const;

  /// The frame's number in the drive.
  std::size_t original(std::size_t i) const { return i * alteration_.every; }

 private:
  std::shared_ptr<const Sequence> drive_;
  DriveAlteration alteration_;
};

}  // namespace estancia::experiments
