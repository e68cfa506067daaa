// RGB-D odometry: camera trajectory by tracking, loop closure and pose graph optimization.
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
  /// What alignment minimizes: "depth" (point to plane; the most exact where depth and color are not
  /// registered), "color" (photometric; needs texture), "hybrid" (both), or "auto": depth, and hybrid where
  /// depth alone is degenerate, as along a bare wall.
  std::string term = "auto";
  /// Images are halved until they are at most this wide [pixels]: more is slower, and on a Kinect no better.
  int maxWidth = 160;
  /// Larger depths are too noisy for alignment [m].
  double maxDepth = 4;
  /// A frame that overlaps less than this with the keyframe becomes the next one [share of its points].
  double keyframeOverlap = 0.7;
  /// A frame that overlaps less than this with the keyframe is lost …
  double minOverlap = 0.35;
  /// … and one whose common points differ by more than this in depth [m, root mean square] …
  double maxRmse = 0.03;
  /// … or whose gray values correlate less than this: bare walls have the same shape everywhere.
  double minCorrelation = 0.5;
  /// Largest translation between two frames [m]; beyond, tracking is lost.
  double maxMotion = 0.7;
  /// Largest rotation between two frames [degrees]; beyond, tracking is lost.
  double maxTurn = 50;
  /// Longer intervals between time stamps are gaps, over which motion is not extrapolated [s].
  double maxGap = 1;

  /// Earlier keyframes, the most similar by words, that are verified for a loop closure; 0 closes none.
  int loopCandidates = 8;
  /// Keyframes closer than this are no loop.
  int minLoopKeyframes = 4;
  /// Smallest overlap of a loop closure.
  double minLoopOverlap = 0.4;
  /// Features that must agree on the motion of a loop closure. Raise it where rooms look alike.
  int minLoopFeatures = 25;

  /// 0: one a free core. The result does not depend on it.
  int threads = 0;
};
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
