// RGB-D odometry: camera trajectory by tracking, loop closure and pose graph optimization.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
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
#include "estancia/io/sequence.hpp"

namespace estancia {

struct RgbdOptions {
  std::string term = "auto";
  int maxWidth = 160;
  double maxDepth = 4;
  double keyframeOverlap = 0.7;
  double minOverlap = 0.35;
  double maxRmse = 0.03;
  double minCorrelation = 0.5;
  double maxMotion = 0.7;
  double maxTurn = 50;
  double maxGap = 1;
  int loopCandidates = 8;
  int minLoopKeyframes = 4;
  double minLoopOverlap = 0.4;
  int minLoopFeatures = 25;
  int threads = 0;
};
/// Says what each option is, its unit and its range.
OptionGroup declare(RgbdOptions& options);
/// Throws Error (invalidOption, unknownName).
void validate(const RgbdOptions& options);

/// Words of a frame, needed for keyframes and lost frames only; empty where it has none. Without them no
/// loops are closed, and a lost camera is relocalized only where it was lost.
struct FrameWords {
  std::function<LexicalDescriptor(std::size_t frame)> describe;
  /// Vocabulary::layout().parts
  std::vector<LabelPart> parts;
};

struct RgbdTrajectory {
  /// T_map_camera of every frame; nothing where the camera was lost. The map's origin is the first tracked
  /// camera, which looks along x and is assumed to be level (z up).
  std::vector<std::optional<Pose>> poses;
  struct Lost {
    std::size_t frame;
    std::string why;
  };
  std::vector<Lost> lost;
  /// Frames.
  std::vector<std::size_t> keyframes;
  /// Pairs of frames of the accepted loop closures.
  std::vector<std::pair<std::size_t, std::size_t>> loops;
  /// Sentences: time gaps, relocalizations.
  std::vector<std::string> notes;
};

/// Tracks every frame against the latest keyframe by Open3D's RGB-D odometry (Steinbrücker et al. 2011; Park
/// et al. 2017), proposes keyframes with similar words as loop closures, verifies these by features and
/// alignment, and optimizes the pose graph (Choi et al. 2015). Frames that cannot be tracked have no pose.
/// The result depends neither on the number of threads nor on the clock. Memory grows by about 0.2 MB a
/// keyframe. Throws Error (invalidInput, insufficientData, invalidOption, unknownName, missingDependency)
/// when there is no depth, no camera, no frame with usable depth, an option is out of range, or Open3D is
/// missing; Interrupted.
RgbdTrajectory trackRgbd(const Sequence& sequence, const RgbdOptions& options = {},
                         const FrameWords& words = {}, Progress& progress = Progress::none());

}  // namespace estancia
