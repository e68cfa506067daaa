// RGB-D odometry: camera trajectory by tracking, loop closure and pose graph optimization.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/options.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/core/vocabulary.hpp"
#include "estancia/sequences/sequence.hpp"

namespace estancia {

struct RgbdOptions {
  std::string term = "auto";
  int maxWidth = 160;
  double maxDepth = 8;
  /// Share of a frame's points in the keyframe, 0.35 to 1, below which it becomes the next one.
  double keyframeOverlap = 0.7;
  double odomShift = 3;
  double odomTurn = 2;
  /// A correction must move what a keyframe shows by this distance [m], until earlier poses are changed while
  /// the camera drives: a change of poses lets maps be fused anew.
  double minCorrection = 0.02;
  /// Keyframes, those that overlap most and the most similar by words, verified for a loop closure; 0 closes
  /// none.
  int loopCandidates = 8;
  int minLoopFeatures = 25;
  int threads = 0;
};
/// Declares the options, their units and their ranges.
OptionGroup declare(RgbdOptions& options);
/// Throws Error (invalidOption, unknownName).
void validate(const RgbdOptions& options);

/// Words of a frame, needed for keyframes and lost frames only; empty where it has none. Without them loops
/// are closed only where drift leaves an overlap, and a lost camera is relocalized only where it was lost.
struct FrameWords {
  std::function<LexicalDescriptor(std::size_t frame)> describe;
  /// Vocabulary::layout().parts
  std::vector<LabelPart> parts;
};

/// The motion as another sensor measured it, as wheel odometry: T_odom_camera of every frame, in any fixed
/// frame `odom`; nothing where it is not known.
using MotionPrior = std::vector<std::optional<Pose>>;

struct RgbdTrajectory {
  /// T_map_camera of every frame; nothing where the camera was lost. The map's origin is the first tracked
  /// camera, which looks along x and is assumed to be level (z up).
  std::vector<std::optional<Pose>> poses;
  struct Untracked {
    std::size_t frame;
    std::string why;
  };
  /// Frames without a pose.
  std::vector<Untracked> lost;
  /// Frames that could not be tracked and whose pose is that of the prior, or else, of up to ten in a row
  /// that do not fit each other, of a steady motion between the tracked frames around them.
  std::vector<Untracked> bridged;
  /// Frames.
  std::vector<std::size_t> keyframes;
  /// Pairs of frames of the accepted loop closures.
  std::vector<std::pair<std::size_t, std::size_t>> loops;
  /// Sentences: time gaps.
  std::vector<std::string> notes;
  /// T_map_camera of every frame as it was known when the frame had just been seen, by earlier frames alone.
  std::vector<std::optional<Pose>> online;
  /// How often poses of earlier frames were corrected since (RgbdTracker::revision()).
  std::uint64_t corrections = 0;
};

/// Aligns every frame with the keyframes around it, from the best of several guesses (the motion so far or
/// the prior's, features), by point-to-plane distances and gray values together (Kerl et al. 2013). Keyframes
/// that overlap, or have similar words, are aligned with each other, and a pose graph is optimized over all
/// of these motions (Choi et al. 2015). Frames that cannot be tracked are named. The result depends neither
/// on the number of threads nor on the clock. It is an RgbdTracker that is given all frames. `prior` is empty
/// or has an entry a frame. Throws Error (invalidInput, insufficientData, invalidOption, unknownName,
/// mismatch, missingDependency) when there is no depth, no camera, no usable depth, an option is out of
/// range, the prior has another number of frames, or the module of Ceres is missing; Interrupted.
RgbdTrajectory trackRgbd(const Sequence& sequence, const RgbdOptions& options = {},
                         const FrameWords& words = {}, Progress& progress = Progress::none(),
                         const MotionPrior& prior = {});

}  // namespace estancia
