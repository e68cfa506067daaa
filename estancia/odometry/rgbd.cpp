// SPDX-License-Identifier: Apache-2.0
#include "estancia/odometry/rgbd.hpp"

#include <fmt/format.h>

#include <cmath>
#include <future>
#include <memory>
#include <numbers>

#include "estancia/core/fail.hpp"
#include "estancia/core/rigid.hpp"
#include "estancia/odometry/alignment.hpp"
#include "estancia/odometry/keyframes.hpp"

namespace estancia {
namespace {

using odometry::align;
using odometry::Alignment;
using odometry::FrameView;
using odometry::Keyframes;
using odometry::viewOf;

/// A small motion, extrapolated.
cv::Affine3d times(const cv::Affine3d& motion, double count) {
  return {count * motion.rvec(), count * motion.translation()};
}

/// The pose of a frame relative to its keyframe, so that it moves when the keyframe is moved.
struct Placed {
  std::size_t keyframe;
  cv::Affine3d inKeyframe;  ///< T_keyframe_frame
};

/// Reads the next frame while the current one is aligned.
class Prefetcher {
 public:
  Prefetcher(const Sequence& sequence, const RgbdOptions& options) : sequence_(sequence), options_(options) {
    start();
  }

  std::unique_ptr<FrameView> next() {
    auto view = upcoming_.get();
    ++frame_;
    start();
    return view;
  }

 private:
  void start() {
    if (frame_ < sequence_.size())
      upcoming_ =
          std::async(std::launch::async, [this, i = frame_] { return viewOf(sequence_, i, options_); });
  }

  const Sequence& sequence_;
  const RgbdOptions& options_;
  std::size_t frame_ = 0;
  std::future<std::unique_ptr<FrameView>> upcoming_;
};

class Tracker {
 public:
  Tracker(const Sequence& sequence, const RgbdOptions& options, const FrameWords& words)
      : sequence_(sequence), options_(options), keyframes_(options, words), placed_(sequence.size()) {}

  void add(std::unique_ptr<FrameView> view);
  RgbdTrajectory finish(Progress& progress);

 private:
  bool good(const Alignment& a, double minOverlap) const;
  bool follow(const FrameView& view);
  bool fitsKeyframe(const FrameView& view);
  bool promoteLast();
  std::optional<std::size_t> relocalize(const FrameView& view);
  std::optional<Alignment> against(std::size_t keyframe, const FrameView& view,
                                   const cv::Affine3d& guess) const;
  void place(const FrameView& view, std::size_t keyframe, const Alignment& alignment);
  bool tooFar(const cv::Affine3d& motion) const;

  cv::Affine3d poseOfFrame(const Placed& placed) const {
    return keyframes_.pose(placed.keyframe) * placed.inKeyframe;
  }

  const Sequence& sequence_;
  const RgbdOptions& options_;
  Keyframes keyframes_;
  std::vector<std::optional<Placed>> placed_;
  std::unique_ptr<FrameView> last_;   ///< the latest tracked frame
  cv::Affine3d lastPose_, velocity_;  ///< its pose, and its motion a frame
  std::size_t current_ = 0;           ///< the keyframe against which frames are tracked
  bool lost_ = false;
  RgbdTrajectory result_;
};

bool Tracker::good(const Alignment& a, double minOverlap) const {
  return a.solved && a.overlap >= minOverlap && a.rmse <= options_.maxRmse &&
         a.correlation >= options_.minCorrelation;
}

bool Tracker::tooFar(const cv::Affine3d& motion) const {
  return cv::norm(motion.translation()) > options_.maxMotion ||
         angleOf(motion) > options_.maxTurn * std::numbers::pi / 180;
}

/// The alignment of the frame with the keyframe, if it is good; guess: T_map_frame.
std::optional<Alignment> Tracker::against(std::size_t keyframe, const FrameView& view,
                                          const cv::Affine3d& guess) const {
  const Alignment a = align(view.pyramid, keyframes_.pyramid(keyframe),
                            keyframes_.pose(keyframe).inv() * guess, keyframes_.alignment());
  if (!good(a, options_.minOverlap)) return std::nullopt;
  return a;
}

/// Stores the pose of the frame; one with little overlap becomes the next keyframe.
void Tracker::place(const FrameView& view, std::size_t keyframe, const Alignment& alignment) {
  placed_[view.frame] = Placed{keyframe, alignment.transform};
  current_ = keyframe;
  if (alignment.overlap < options_.keyframeOverlap) {
    const std::size_t added = keyframes_.add(view, keyframes_.pose(keyframe) * alignment.transform);
    keyframes_.connect(added, keyframe, alignment);
    placed_[view.frame] = Placed{added, cv::Affine3d::Identity()};
    current_ = added;
  }
}

/// Tracks the frame against the current keyframe: from the extrapolated motion, from no motion, from
/// features. After frames without depth, features are tried first, because alignment along planes is
/// ambiguous when the last frame is far away.
bool Tracker::fitsKeyframe(const FrameView& view) {
  const std::size_t steps = view.frame - last_->frame;
  const auto fits = [&](const cv::Affine3d& guess) {
    const auto found = against(current_, view, guess);
    if (!found || tooFar(lastPose_.inv() * keyframes_.pose(current_) * found->transform)) return false;
    place(view, current_, *found);
    return true;
  };
  const auto byMotion = [&] {
    const bool moves = cv::norm(velocity_.translation()) + angleOf(velocity_) > 0.01;
    return fits(lastPose_ * times(velocity_, static_cast<double>(steps))) || (moves && fits(lastPose_));
  };
  const auto byFeatures = [&] {
    const auto guess = keyframes_.guess(view, current_);
    return guess && fits(keyframes_.pose(current_) * *guess);
  };
  return steps == 1 ? byMotion() || byFeatures() : byFeatures() || byMotion();
}

/// Makes the last tracked frame the current keyframe.
bool Tracker::promoteLast() {
  if (keyframes_.frame(current_) == last_->frame) return false;
  const Placed& previous = *placed_[last_->frame];
  const Alignment edge = align(last_->pyramid, keyframes_.pyramid(previous.keyframe), previous.inKeyframe,
                               keyframes_.alignment());
  if (!good(edge, options_.minOverlap)) return false;
  const std::size_t added = keyframes_.add(*last_, lastPose_);
  keyframes_.connect(added, previous.keyframe, edge);
  placed_[last_->frame] = Placed{added, cv::Affine3d::Identity()};
  current_ = added;
  return true;
}

bool Tracker::follow(const FrameView& view) {
  return fitsKeyframe(view) || (promoteLast() && fitsKeyframe(view));
}

/// Tries the keyframe where the camera was lost, and those with similar words. Features must agree, because
/// any wall aligns with any other. Returns the keyframe that fits.
std::optional<std::size_t> Tracker::relocalize(const FrameView& view) {
  std::vector<std::size_t> candidates{current_};
  for (const std::size_t k : keyframes_.withSimilarWords(view))
    if (k != current_) candidates.push_back(k);
  for (const std::size_t k : candidates)
    if (const auto guess = keyframes_.guess(view, k))
      if (const auto found = against(k, view, keyframes_.pose(k) * *guess)) {
        place(view, k, *found);
        return k;
      }
  return std::nullopt;
}

void Tracker::add(std::unique_ptr<FrameView> view) {
  const std::size_t i = view->frame;
  if (!view->problem.empty()) {  // the camera is not lost: tracking continues with the next frame
    result_.lost.push_back({i, view->problem});
    return;
  }
  if (keyframes_.size() == 0) {
    placed_[i] = Placed{keyframes_.add(*view, rigidOf(Pose::planar(0, 0, 0))), cv::Affine3d::Identity()};
  } else {
    const auto &before = sequence_.frame(last_->frame).timestamp, &now = sequence_.frame(i).timestamp;
    if (before && now && std::abs(*now - *before) > options_.maxGap) {
      velocity_ = cv::Affine3d::Identity();
      if (!lost_)
        result_.notes.push_back(fmt::format("{:.1f} s without {} before {}", *now - *before,
                                            last_->frame + 1 == i ? "an image" : "usable depth",
                                            sequence_.frame(i).name));
    }
    if (lost_ || !follow(*view)) {
      const auto beside = relocalize(*view);
      if (!beside) {
        result_.lost.push_back({i, "it fits no keyframe"});
        lost_ = true;
        return;
      }
      if (lost_)
        result_.notes.push_back(fmt::format("found again at {}, beside {}", sequence_.frame(i).name,
                                            sequence_.frame(keyframes_.frame(*beside)).name));
    }
  }
  const cv::Affine3d pose = poseOfFrame(*placed_[i]);
  velocity_ = last_ && !lost_ ? times(lastPose_.inv() * pose, 1 / static_cast<double>(i - last_->frame))
                              : cv::Affine3d::Identity();
  lastPose_ = pose;
  last_ = std::move(view);
  lost_ = false;
}

RgbdTrajectory Tracker::finish(Progress& progress) {
  if (keyframes_.size() == 0)
    fail(ErrorCode::insufficientData, "{}: no frame can be tracked; the first: {}", sequence_.name(),
         result_.lost.front().why);
  keyframes_.closeLoops(progress);
  for (const auto& [a, b] : keyframes_.optimize())
    result_.loops.emplace_back(keyframes_.frame(a), keyframes_.frame(b));
  for (std::size_t k = 0; k < keyframes_.size(); ++k) result_.keyframes.push_back(keyframes_.frame(k));
  for (const auto& placed : placed_)
    result_.poses.push_back(placed ? std::optional(poseOf(poseOfFrame(*placed))) : std::nullopt);
  return std::move(result_);
}

void requireRgbd(const Sequence& sequence) {
  if (sequence.size() == 0)
    fail(ErrorCode::insufficientData, "{}: the sequence has no frames", sequence.name());
  if (!sequence.hasDepth())
    fail(ErrorCode::invalidInput,
         "{}: odometry needs depth images; `estancia check` says where they are expected, and "
         "--poses takes a trajectory from elsewhere",
         sequence.name());
  if (!sequence.intrinsics())
    fail(ErrorCode::invalidInput,
         "{}: the camera's intrinsics are missing; give them by --intrinsics (`estancia check` "
         "shows what fits)",
         sequence.name());
}

}  // namespace

OptionGroup declare(RgbdOptions& o) {
  OptionGroup group("odometry", "RGB-D odometry.");
  group.add("term", &o.term, "What alignment minimizes").choices(odometry::alignmentTerms());
  group.add("max-width", &o.maxWidth, "Images are halved until they are at most this wide")
      .range(48, 4096)
      .unit("pixels")
      .why("Larger images take longer, and gain little with the noise of depth cameras.");
  group.add("max-depth", &o.maxDepth, "Depth beyond is not used: it is too noisy for alignment")
      .above(0, 1000)
      .unit("m");
  group
      .add("keyframe-overlap", &o.keyframeOverlap,
           "Share of a frame's points in the keyframe, below which it becomes the next one")
      .above(0, 1);
  group.add("min-overlap", &o.minOverlap, "Overlap below which a frame is lost").above(0, 1);
  group.add("max-rmse", &o.maxRmse, "Difference in depth (root mean square) above which a frame is lost")
      .above(0)
      .unit("m");
  group.add("min-correlation", &o.minCorrelation, "Correlation of gray values below which a frame is lost")
      .range(-1, 1)
      .why("Bare walls have the same shape everywhere.");
  group.add("max-motion", &o.maxMotion, "Largest translation between two frames; beyond, tracking is lost")
      .above(0)
      .unit("m");
  group.add("max-turn", &o.maxTurn, "Largest rotation between two frames; beyond, tracking is lost")
      .above(0)
      .unit("degrees");
  group.add("max-gap", &o.maxGap, "Interval above which motion is not extrapolated").above(0).unit("s");
  group
      .add("loop-candidates", &o.loopCandidates,
           "Keyframes, the most similar by words, verified for a loop closure; 0 closes none")
      .range(0);
  group.add("min-loop-keyframes", &o.minLoopKeyframes, "Keyframes between the ends of a loop").range(1);
  group.add("min-loop-overlap", &o.minLoopOverlap, "Smallest overlap of a loop closure").above(0, 1);
  group.add("min-loop-features", &o.minLoopFeatures, "Features that must agree for a loop closure")
      .range(6)
      .why("Raise it where rooms look alike.");
  group.add("threads", &o.threads, "Threads; 0: one a free core. The result does not depend on it")
      .range(0, 1024);
  return group;
}

void validate(const RgbdOptions& options) {
  RgbdOptions copy = options;
  declare(copy).validate();
  if (options.minOverlap > options.keyframeOverlap)
    fail(ErrorCode::invalidOption,
         "odometry.min-overlap is {} and odometry.keyframe-overlap is {}; give a smaller "
         "min-overlap",
         options.minOverlap, options.keyframeOverlap);
}

RgbdTrajectory trackRgbd(const Sequence& sequence, const RgbdOptions& options, const FrameWords& words,
                         Progress& progress) {
  validate(options);
  requireRgbd(sequence);
  odometry::open3d();

  Tracker tracker(sequence, options, words);
  Prefetcher frames(sequence, options);
  progress.begin("tracking", sequence.size());
  for (std::size_t i = 0; i < sequence.size(); ++i) {
    if (interrupted())
      throw Interrupted(fmt::format(
          "stopped after {} of {} frames; nothing was written, odometry starts anew", i, sequence.size()));
    tracker.add(frames.next());
    progress.advance();
  }
  progress.end();
  return tracker.finish(progress);
}

}  // namespace estancia
