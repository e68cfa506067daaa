// RGB-D tracker: camera poses frame by frame, corrected by loop closures while the camera drives.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "estancia/core/camera.hpp"
#include "estancia/core/descriptor.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/core/vocabulary.hpp"
#include "estancia/odometry/rgbd.hpp"

namespace estancia {

namespace odometry {
struct FrameView;
}

/// Data of a frame beside its pixels.
struct FrameFacts {
  std::string name{};                 ///< for sentences
  std::optional<double> timestamp{};  ///< [s]
  /// The camera's pose as another sensor has it, as wheel odometry: T_odom_camera, in any fixed frame.
  std::optional<Pose> prior{};
  /// Called for keyframes and lost frames only, at most once, by add(); empty without words. Without them
  /// loops are closed only where drift leaves an overlap, and a lost camera is found again only where it
  /// was lost.
  std::function<LexicalDescriptor()> words{};
};

/// Tracks a camera one frame after the other. Every new keyframe is compared with earlier ones, by overlap
/// and by words; where it is aligned with some, the pose graph is optimized, and earlier poses may change:
/// revision() counts this. The camera is tracked among the keyframes that are known to be around it, old
/// ones, too; so keyframes (about 90 kB each) grow with what was seen, not with the time. The work for a
/// frame is bounded, but for a look at all keyframes when there is a new one (some microseconds each), and
/// for the optimization of all their poses when a long loop is closed (a millisecond each). For one thread;
/// prepare() is for any.
class RgbdTracker {
 public:
  struct Placement {
    /// T_map_camera; nothing when the frame is not placed (yet). The map's origin is the first camera, which
    /// looks along x and is assumed to be level (z up). The map is the largest part of the drive that holds
    /// together.
    std::optional<Pose> pose;
    /// Why it was not tracked; "" when it was. With a pose it is bridged: placed by the prior, or by a steady
    /// motion between the tracked frames around it.
    std::string why;
  };

  /// `camera` is that of images and depth, in any size; `parts` are Vocabulary::layout().parts of the words.
  /// Throws Error (invalidOption, unknownName, missingDependency; invalidInput for a camera without size).
  explicit RgbdTracker(const CameraIntrinsics& camera, const RgbdOptions& options = {},
                       const std::vector<LabelPart>& parts = {});
  RgbdTracker(RgbdTracker&&) noexcept;
  RgbdTracker& operator=(RgbdTracker&&) noexcept;
  ~RgbdTracker();

  using View = std::shared_ptr<const odometry::FrameView>;
  /// Computes what does not depend on the frames before. Never throws because of unusable images: add()
  /// reports them.
  View prepare(const cv::Mat& image, const cv::Mat& depth, const std::string& name = "") const;

  /// The next frame is another drive's: the camera may be anywhere, and is looked for among all keyframes. To
  /// be called again after restore() where no frame followed.
  void beginDrive();
  /// The next frame: `image` is BGR of 8 bits, `depth` is CV_32F [m], 0 where unknown; same view, sizes may
  /// differ from each other and from frame to frame. Frames that cannot be tracked are named in the answer.
  /// Throws Error (mismatch) when the number of words changes.
  Placement add(const cv::Mat& image, const cv::Mat& depth, const FrameFacts& facts = {});
  Placement add(const View& view, const FrameFacts& facts);
  /// The next frame, which could not be read: `why` is reported for it.
  Placement skip(const std::string& why, const FrameFacts& facts);

  /// Frames so far.
  std::size_t size() const;
  /// A frame as it is known now.
  Placement at(std::size_t frame) const;
  /// T_from_to by the latest optimum, of two frames that were tracked in the same part of the drive, also
  /// where that part has no place in the map yet; nothing of others.
  std::optional<Pose> motion(std::size_t from, std::size_t to) const;
  /// Grows when at() of tracked frames before the latest changed: where their keyframes see things more than
  /// RgbdOptions::minCorrection elsewhere, or parts of the drive were joined. Frames that are bridged may
  /// move, or get their pose, without it.
  std::uint64_t revision() const;
  /// Applies smaller corrections, too. Tracking goes on as without it.
  void settle();

  /// All of it. `online` is not known of frames before restore().
  RgbdTrajectory trajectory() const;

  /// The state as rows, to go on from it after a crash: to the last bit as if nothing had happened.
  struct Row {
    std::uint64_t number;
    std::string bytes;
  };
  struct State {
    /// All that changes with every frame, about 60 kB and 250 bytes a keyframe.
    std::string head;
    /// About 50 kB each, and 150 bytes each: those that are new, or replace that of the same number.
    std::vector<Row> keyframes, frames;
  };
  /// Changes since the last save(); everything the first time.
  State save();
  /// Rows in any order; those beyond what the head counts are ignored. Throws Error: malformedFile,
  /// truncatedFile, mismatch for other options or another camera.
  static RgbdTracker restore(const CameraIntrinsics& camera, const RgbdOptions& options,
                             const std::vector<LabelPart>& parts, const State& state);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace estancia
