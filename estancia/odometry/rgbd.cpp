// SPDX-License-Identifier: Apache-2.0
#include "estancia/odometry/rgbd.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <numbers>

#include "estancia/core/fail.hpp"
#include "estancia/core/rigid.hpp"
#include "estancia/odometry/alignment.hpp"
#include "estancia/odometry/bridge.hpp"
#include "estancia/odometry/keyframes.hpp"
#include "estancia/odometry/loops.hpp"
#include "estancia/odometry/prior.hpp"

namespace estancia {
namespace {

using odometry::align;
using odometry::Alignment;
using odometry::AlignmentOptions;
using odometry::AlignmentTarget;
using odometry::FrameView;
using odometry::isGood;
using odometry::isTooFar;
using odometry::Keyframes;
using odometry::Motion;
using odometry::PoseGraphEdge;
using odometry::priorMotion;
using odometry::times;
using odometry::viewOf;

constexpr std::size_t kTargets = 2;  // keyframes that a frame is aligned with at once
constexpr int kGuessFeatures = 12;   // that must agree for a guess, which then is put to the test
constexpr double kUnknownTurn = 0.3, kUnknownShift = 0.5;  // [rad], [m] of a motion that nothing measured

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

/// Whether another pose would lead an alignment to the same.
auto isNear(const cv::Affine3d& pose) {
  return [&pose](const cv::Affine3d& other) {
    const cv::Affine3d motion = other.inv() * pose;
    return cv::norm(motion.translation()) + angleOf(motion) < 0.01;
  };
}

class Tracker {
 public:
  Tracker(const Sequence& sequence, const RgbdOptions& options, const FrameWords& words,
          const MotionPrior& prior)
      : sequence_(sequence),
        options_(options),
        prior_(prior),
        keyframes_(options, words),
        placed_(sequence.size()) {
    how_.term = odometry::alignmentTerm(options.term);
  }

  void add(std::unique_ptr<FrameView> view);
  RgbdTrajectory finish(Progress& progress);

 private:
  struct Found {
    std::size_t keyframe;
    Alignment alignment;
  };
  cv::Affine3d predicted(const FrameView& view) const;
  std::vector<cv::Affine3d> guessesByMotion(const FrameView& view) const;
  std::vector<cv::Affine3d> guessesByFeatures(const FrameView& view) const;
  std::optional<Found> refined(const FrameView& view, const cv::Affine3d& guess, std::size_t finest) const;
  std::optional<Found> fit(const FrameView& view) const;
  bool promoteLast();
  std::optional<Found> relocalize(const FrameView& view) const;
  void place(const FrameView& view, const Found& found);
  void startAnew(const FrameView& view);
  void sayGap(const FrameView& view);
  std::vector<PoseGraphEdge> assumed() const;
  void report(const std::vector<std::size_t>& parts);

  cv::Affine3d poseOfFrame(const Placed& placed) const {
    return keyframes_.pose(placed.keyframe) * placed.inKeyframe;
  }

  const Sequence& sequence_;
  const RgbdOptions& options_;
  const MotionPrior& prior_;
  AlignmentOptions how_;
  Keyframes keyframes_;
  std::vector<PoseGraphEdge> tracked_;           ///< motions between keyframes
  std::vector<PoseGraphEdge> guessed_;           ///< the same where nothing measured them
  std::map<std::size_t, std::string> problems_;  ///< of frames that cannot be aligned
  std::vector<std::optional<Placed>> placed_;
  std::unique_ptr<FrameView> last_;   ///< the latest frame with a pose
  cv::Affine3d lastPose_, velocity_;  ///< its pose, and its motion a frame
  std::size_t current_ = 0;           ///< the keyframe of the latest frame
  RgbdTrajectory result_;
};

/// T_map_view as the motion so far goes on, or as the prior says.
cv::Affine3d Tracker::predicted(const FrameView& view) const {
  if (const auto motion = priorMotion(prior_, last_->frame, view.frame, options_))
    return lastPose_ * motion->transform;
  return lastPose_ * times(velocity_, static_cast<double>(view.frame - last_->frame));
}

/// Guesses of T_map_view without a look at features: the prior, the motion so far, none.
std::vector<cv::Affine3d> Tracker::guessesByMotion(const FrameView& view) const {
  return {predicted(view), lastPose_ * times(velocity_, static_cast<double>(view.frame - last_->frame)),
          lastPose_};
}

/// Guesses of T_map_view by matched features.
std::vector<cv::Affine3d> Tracker::guessesByFeatures(const FrameView& view) const {
  std::vector<cv::Affine3d> found;
  const auto& keyframe = keyframes_[current_];
  if (const auto motion = guessFromFeatures(view.features, keyframe.features, kGuessFeatures))
    found.push_back(keyframe.pose * *motion);
  if (last_->frame != keyframe.frame)
    if (const auto motion = guessFromFeatures(view.features, last_->features, kGuessFeatures))
      found.push_back(lastPose_ * *motion);
  return found;
}

/// Aligns the view with the keyframes around the guess.
std::optional<Tracker::Found> Tracker::refined(const FrameView& view, const cv::Affine3d& guess,
                                               std::size_t finest) const {
  const auto around = keyframes_.around(view, guess, kTargets);
  if (around.empty()) return std::nullopt;
  std::vector<AlignmentTarget> targets;
  for (const std::size_t k : around) targets.push_back({&keyframes_.pyramid(k), keyframes_.pose(k)});
  AlignmentOptions how = how_;
  how.finest = finest;
  const Alignment a = align(view.pyramid, targets, guess, how);
  if (!a.solved) return std::nullopt;
  return Found{around.front(), a};
}

/// Takes the guess that fits best on the coarsest level, and refines it.
std::optional<Tracker::Found> Tracker::fit(const FrameView& view) const {
  std::vector<std::pair<double, cv::Affine3d>> ranked;
  std::vector<cv::Affine3d> tried;
  const auto rank = [&](const std::vector<cv::Affine3d>& guesses) {
    for (const cv::Affine3d& guess : guesses) {
      if (isTooFar(lastPose_.inv() * guess, options_) || std::ranges::any_of(tried, isNear(guess))) continue;
      tried.push_back(guess);
      if (const auto found = refined(view, guess, view.pyramid.size() - 1))
        ranked.emplace_back(found->alignment.agreement, found->alignment.transform);
    }
    std::ranges::stable_sort(ranked, std::greater(), &std::pair<double, cv::Affine3d>::first);
  };
  rank(guessesByMotion(view));
  // A guess that agrees as much as a frame without need of a keyframe is clear without features.
  if (ranked.empty() || ranked.front().first < options_.keyframeOverlap) rank(guessesByFeatures(view));
  for (const auto& [agreement, guess] : ranked) {
    const auto found = refined(view, guess, 0);
    if (found && isGood(found->alignment, options_.minOverlap, options_) &&
        !isTooFar(lastPose_.inv() * found->alignment.transform, options_))
      return found;
  }
  return std::nullopt;
}

/// Stores the pose of the frame; one with little overlap becomes a keyframe.
void Tracker::place(const FrameView& view, const Found& found) {
  const auto& [keyframe, alignment] = found;
  const cv::Affine3d motion = keyframes_.pose(keyframe).inv() * alignment.transform;
  placed_[view.frame] = Placed{keyframe, motion};
  current_ = keyframe;
  if (alignment.overlap >= options_.keyframeOverlap) return;
  current_ = keyframes_.add(view, alignment.transform);
  tracked_.push_back({current_, keyframe, motion, odometry::covarianceOf(alignment.information)});
  placed_[view.frame] = Placed{current_, cv::Affine3d::Identity()};
}

/// Makes the last tracked frame a keyframe.
bool Tracker::promoteLast() {
  if (keyframes_[current_].frame == last_->frame) return false;
  const auto found = refined(*last_, lastPose_, 0);
  if (!found || !isGood(found->alignment, options_.minOverlap, options_)) return false;
  const std::size_t added = keyframes_.add(*last_, found->alignment.transform);
  tracked_.push_back({added, found->keyframe,
                      keyframes_.pose(found->keyframe).inv() * found->alignment.transform,
                      odometry::covarianceOf(found->alignment.information)});
  placed_[last_->frame] = Placed{added, cv::Affine3d::Identity()};
  lastPose_ = found->alignment.transform;
  current_ = added;
  return true;
}

/// Tries the keyframe where the camera was lost, and those with similar words. Features must agree, because
/// any wall aligns with any other.
std::optional<Tracker::Found> Tracker::relocalize(const FrameView& view) const {
  std::vector<std::size_t> candidates{current_};
  for (const std::size_t k : keyframes_.withSimilarWords(view))
    if (k != current_) candidates.push_back(k);
  for (const std::size_t k : candidates)
    if (const auto guess =
            guessFromFeatures(view.features, keyframes_[k].features, options_.minLoopFeatures)) {
      const AlignmentTarget target{&keyframes_.pyramid(k), keyframes_.pose(k)};
      const Alignment a = align(view.pyramid, {&target, 1}, keyframes_.pose(k) * *guess, how_);
      if (isGood(a, options_.minOverlap, options_)) return Found{k, a};
    }
  return std::nullopt;
}

/// A keyframe where the motion so far would have led; loops tell later where it is.
void Tracker::startAnew(const FrameView& view) {
  const cv::Affine3d pose = predicted(view);
  const std::size_t before = current_;
  current_ = keyframes_.add(view, pose);
  cv::Matx66d unknown = cv::Matx66d::zeros();
  for (int i = 0; i < 6; ++i)
    unknown(i, i) = i < 3 ? kUnknownTurn * kUnknownTurn : kUnknownShift * kUnknownShift;
  guessed_.push_back({current_, before, keyframes_.pose(before).inv() * pose, unknown});
  placed_[view.frame] = Placed{current_, cv::Affine3d::Identity()};
}

void Tracker::sayGap(const FrameView& view) {
  const auto &before = sequence_.frame(last_->frame).timestamp, &now = sequence_.frame(view.frame).timestamp;
  if (!before || !now || std::abs(*now - *before) <= options_.maxGap) return;
  velocity_ = cv::Affine3d::Identity();
  result_.notes.push_back(fmt::format("{:.1f} s without {} before {}", *now - *before,
                                      last_->frame + 1 == view.frame ? "an image" : "usable depth",
                                      sequence_.frame(view.frame).name));
}

void Tracker::add(std::unique_ptr<FrameView> view) {
  const std::size_t i = view->frame;
  if (!view->problem.empty()) {  // the camera is not lost: tracking continues with the next frame
    problems_[i] = view->problem;
    return;
  }
  bool steady = false;
  if (keyframes_.size() == 0) {
    placed_[i] = Placed{keyframes_.add(*view, rigidOf(Pose::planar(0, 0, 0))), cv::Affine3d::Identity()};
  } else {
    sayGap(*view);
    auto found = fit(*view);
    if (!found && promoteLast()) found = fit(*view);
    steady = found.has_value();
    if (!found) found = relocalize(*view);
    if (found) {
      place(*view, *found);

    } else {
      startAnew(*view);
    }
  }
  const cv::Affine3d pose = poseOfFrame(*placed_[i]);
  velocity_ = steady ? times(lastPose_.inv() * pose, 1 / static_cast<double>(i - last_->frame))
                     : cv::Affine3d::Identity();
  lastPose_ = pose;
  last_ = std::move(view);
}

/// Motions between keyframes that no image tells: the prior's, and those guessed where tracking failed.
std::vector<PoseGraphEdge> Tracker::assumed() const {
  std::vector<PoseGraphEdge> edges = guessed_;
  for (std::size_t k = 1; k < keyframes_.size(); ++k)
    if (const auto motion = priorMotion(prior_, keyframes_[k - 1].frame, keyframes_[k].frame, options_))
      edges.push_back({k, k - 1, motion->transform, motion->covariance});
  return edges;
}

/// Poses of all frames; those whose keyframe is connected with the largest part of the map by images are
/// tracked, others are named.
void Tracker::report(const std::vector<std::size_t>& parts) {
  std::map<std::size_t, std::size_t> frames;
  for (const auto& placed : placed_)
    if (placed) ++frames[parts[placed->keyframe]];
  const std::size_t map =
      std::ranges::max_element(frames, {}, [](const auto& part) { return part.second; })->first;
  std::vector<std::optional<cv::Affine3d>> tracked(placed_.size());
  std::optional<cv::Affine3d> toMap;  // the first tracked camera is the origin
  for (std::size_t i = 0; i < placed_.size(); ++i) {
    if (!placed_[i] || parts[placed_[i]->keyframe] != map) continue;
    const cv::Affine3d pose = poseOfFrame(*placed_[i]);
    if (!toMap) toMap = rigidOf(Pose::planar(0, 0, 0)) * pose.inv();
    tracked[i] = *toMap * pose;
  }
  for (std::size_t i = 0; i < placed_.size(); ++i) {
    const auto pose = tracked[i] ? tracked[i] : odometry::bridged(tracked, i, prior_, options_);
    result_.poses.push_back(pose ? std::optional(poseOf(*pose)) : std::nullopt);
    if (tracked[i]) continue;
    const auto problem = problems_.find(i);
    (pose ? result_.bridged : result_.lost)
        .push_back({i, problem == problems_.end() ? "it fits no keyframe, or shows nothing to hold on to"
                                                  : problem->second});
  }
}

RgbdTrajectory Tracker::finish(Progress& progress) {
  if (keyframes_.size() == 0)
    fail(ErrorCode::insufficientData, "{}: no frame can be tracked; the first: {}", sequence_.name(),
         problems_.begin()->second);
  std::vector<PoseGraphEdge> seen = tracked_;
  for (const PoseGraphEdge& loop : closeLoops(keyframes_, tracked_, assumed(), options_, progress)) {
    seen.push_back(loop);
    if (loop.source - loop.target >= static_cast<std::size_t>(options_.minLoopKeyframes))
      result_.loops.emplace_back(keyframes_[loop.source].frame, keyframes_[loop.target].frame);
  }
  for (std::size_t k = 0; k < keyframes_.size(); ++k) result_.keyframes.push_back(keyframes_[k].frame);
  report(odometry::partsOf(keyframes_.size(), seen));
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
  group.add("max-depth", &o.maxDepth, "Depth beyond is not used").above(0, 1000).unit("m");
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
      .add("odom-shift", &o.odomShift,
           "Uncertainty of the prior's motion: standard deviation of a step's length, of that length")
      .above(0, 1000)
      .unit("%");
  group.add("odom-turn", &o.odomTurn, "Uncertainty of the prior's turn: standard deviation of a step")
      .above(0, 180)
      .unit("degrees");
  group
      .add("loop-candidates", &o.loopCandidates,
           "Keyframes, those that overlap most and the most similar by words, verified for a loop closure; 0 "
           "closes none")
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
                         Progress& progress, const MotionPrior& prior) {
  validate(options);
  requireRgbd(sequence);
  if (!prior.empty() && prior.size() != sequence.size())
    fail(ErrorCode::mismatch, "{}: the prior has {} poses and the sequence {} frames; give one for each",
         sequence.name(), prior.size(), sequence.size());
  Tracker tracker(sequence, options, words, prior);
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
