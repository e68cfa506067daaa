// Where the camera stood in every image of an RGB-D sequence: tracking, loops, and a pose graph.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/core/vocabulary.hpp"
#include "estancia/io/sequence.hpp"

namespace estancia {

struct RgbdOptions {
  /// What alignment compares: "depth" (planes; the most exact where depth and color are not registered),
  /// "color" (gray values; needs texture), "hybrid" (both), or "auto": depth, and hybrid where depth would
  /// slide, as along a bare wall.
  std::string term = "auto";
  /// Images are halved until they are at most so wide [pixels]: more is slower, and on a Kinect no better.
  int width = 160;
  /// Depth beyond this is too noisy to align by [m].
  double farthest = 4;
  /// A frame that shares less than this with the keyframe becomes the next one [share of its points].
  double keyframeOverlap = 0.7;
  /// A frame that shares less than this with the keyframe is lost.
  double leastOverlap = 0.35;
  /// … and so is one whose shared points differ by more than this in depth [m, root mean square].
  double mostRmse = 0.03;
  /// … or look less alike than this [correlation of gray values]: bare walls have the same shape everywhere.
  double leastLikeness = 0.5;
  /// The camera cannot move or turn further than this between two frames [m], [degrees]; beyond, tracking is
  /// lost.
  double mostMotion = 0.7, mostTurn = 50;
  /// Frames with stamps further apart than this are a gap: the motion before it says nothing about the one
  /// over it [s].
  double gap = 1;

  /// So many earlier keyframes, the nearest by words, are looked at for a loop; 0 closes none.
  int loopCandidates = 8;
  /// Keyframes fewer than this apart see the same anyhow; they are no loop.
  int loopKeyframes = 4;
  /// A loop is believed from this share of common points on …
  double loopOverlap = 0.4;
  /// … when so many features agree on the motion. Raise it where rooms look alike.
  int loopFeatures = 25;

  int threads = 0;  ///< 0: one a free core; changes no bit of the result
};

/// The options by name, in order: "term", … Throws Error when one is out of its range.
void requireValid(const RgbdOptions& options);

/// Words of a frame, asked for keyframes and lost frames only; empty where it has none. Not given: no loops
/// are closed, and a lost camera is only looked for where it was lost.
struct FrameWords {
  std::function<LexicalDescriptor(std::size_t frame)> describe;
  std::vector<LabelPart> parts;  ///< Vocabulary::layout().parts
};

struct RgbdTrajectory {
  /// T_map_camera of every frame; nothing where the camera was lost. The map's origin is the first tracked
  /// camera, which looks along x and is taken to be level (z up).
  std::vector<std::optional<Pose>> poses;
  struct Lost {
    std::size_t frame;
    std::string why;
  };
  std::vector<Lost> lost;
  std::vector<std::size_t> keyframes;  ///< frames
  /// Pairs of frames that were believed to see the same.
  std::vector<std::pair<std::size_t, std::size_t>> loops;
  std::vector<std::string> notes;  ///< sentences: time gaps, places where tracking was resumed
};

/// Tracks every frame against the latest keyframe by Open3D's RGB-D odometry (Steinbrücker et al. 2011; Park
/// et al. 2017), takes keyframes that say the same words for loops, verifies these by features and alignment,
/// and makes all agree (Choi et al. 2015). Frames that cannot be placed are left without a pose. The result
/// depends neither on the number of threads nor on the clock. Memory grows by about 0.2 MB a keyframe. Throws
/// Error when there is no depth, no camera, no frame with usable depth, an option is out of range, or Open3D
/// is missing; Interrupted on Ctrl-C.
RgbdTrajectory trackRgbd(const Sequence& sequence, const RgbdOptions& options = {},
                         const FrameWords& words = {}, Progress* progress = nullptr);

}  // namespace estancia
