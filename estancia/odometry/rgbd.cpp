#include "estancia/odometry/rgbd.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <future>
#include <memory>
#include <numbers>

#include "estancia/core/error.hpp"
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

/// A small motion, so many times.
cv::Affine3d times(const cv::Affine3d& motion, double count) {
  return {count * motion.rvec(), count * motion.translation()};
}

/// Where a frame was seen: it moves along when its keyframe is moved.
struct Placed {
  std::size_t keyframe;
  cv::Affine3d inKeyframe;  ///< T_keyframe_frame
};

/// Reads the next frame while the present one is aligned.
class Ahead {
 public:
  Ahead(const Sequence& sequence, const RgbdOptions& options) : sequence_(sequence), options_(options) {
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
  bool good(const Alignment& a, double leastOverlap) const;
  bool follow(const FrameView& view);
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
  std::size_t current_ = 0;           ///< the keyframe that frames are tracked against
  bool lost_ = false;
  RgbdTrajectory result_;
};

bool Tracker::good(const Alignment& a, double leastOverlap) const {
  return a.solved && a.overlap >= leastOverlap && a.rmse <= options_.mostRmse &&
         a.likeness >= options_.leastLikeness;
}

bool Tracker::tooFar(const cv::Affine3d& motion) const {
  return cv::norm(motion.translation()) > options_.mostMotion ||
         angleOf(motion) > options_.mostTurn * std::numbers::pi / 180;
}

/// The frame in the keyframe, when it fits there; guess: T_map_frame.
std::optional<Alignment> Tracker::against(std::size_t keyframe, const FrameView& view,
                                          const cv::Affine3d& guess) const {
  const Alignment a = align(view.pyramid, keyframes_.pyramid(keyframe),
                            keyframes_.pose(keyframe).inv() * guess, keyframes_.alignment());
  if (!good(a, options_.leastOverlap)) return std::nullopt;
  return a;
}

/// Writes down where the frame is; one that shares little with its keyframe becomes the next.
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

/// By the motion so far, without it, by features; then the same beside the previous frame, as the next
/// keyframe. Past frames without depth features go first: so far from the last frame, planes slide.
bool Tracker::follow(const FrameView& view) {
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
    const auto seen = keyframes_.guess(view, current_);
    return seen && fits(keyframes_.pose(current_) * *seen);
  };
  for (const bool promoted : {false, true}) {
    if (promoted) {
      if (keyframes_.frame(current_) == last_->frame) return false;
      const Placed& previous = *placed_[last_->frame];
      const Alignment edge = align(last_->pyramid, keyframes_.pyramid(previous.keyframe), previous.inKeyframe,
                                   keyframes_.alignment());
      if (!good(edge, options_.leastOverlap)) return false;
      const std::size_t added = keyframes_.add(*last_, lastPose_);
      keyframes_.connect(added, previous.keyframe, edge);
      placed_[last_->frame] = Placed{added, cv::Affine3d::Identity()};
      current_ = added;
    }
    if (steps == 1 ? byMotion() || byFeatures() : byFeatures() || byMotion()) return true;
  }
  return false;
}

/// Anywhere: where the camera was lost, and where the same words were seen. Features must agree, for a wall
/// aligns with any wall. The keyframe beside which it was found.
std::optional<std::size_t> Tracker::relocalize(const FrameView& view) {
  std::vector<std::size_t> candidates{current_};
  for (const std::size_t k : keyframes_.sayingTheSame(view))
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
  if (!view->problem.empty()) {  // it says nothing about where the camera is: the next one is followed
    result_.lost.push_back({i, view->problem});
    return;
  }
  if (keyframes_.size() == 0) {
    placed_[i] = Placed{keyframes_.add(*view, rigidOf(Pose::planar(0, 0, 0))), cv::Affine3d::Identity()};
  } else {
    const auto &before = sequence_.frame(last_->frame).timestamp, &now = sequence_.frame(i).timestamp;
    if (before && now && std::abs(*now - *before) > options_.gap) {
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
    throw Error(
        fmt::format("{}: no frame can be placed; the first: {}", sequence_.name(), result_.lost.front().why));
  keyframes_.closeLoops(progress);
  for (const auto& [a, b] : keyframes_.optimize())
    result_.loops.emplace_back(keyframes_.frame(a), keyframes_.frame(b));
  for (std::size_t k = 0; k < keyframes_.size(); ++k) result_.keyframes.push_back(keyframes_.frame(k));
  for (const auto& placed : placed_)
    result_.poses.push_back(placed ? std::optional(poseOf(poseOfFrame(*placed))) : std::nullopt);
  return std::move(result_);
}

void requireRgbd(const Sequence& sequence) {
  if (sequence.size() == 0) throw Error(fmt::format("{}: no frames", sequence.name()));
  if (!sequence.hasDepth())
    throw Error(
        fmt::format("{}: no depth images, which odometry needs; `estancia check` says where they are looked "
                    "for, and --poses takes a trajectory from elsewhere",
                    sequence.name()));
  if (!sequence.intrinsics())
    throw Error(fmt::format(
        "{}: the camera is not known; give its focal lengths and center by --intrinsics (`estancia "
        "check` shows what fits)",
        sequence.name()));
}

}  // namespace

void requireValid(const RgbdOptions& o) {
  const auto require = [](bool valid, const char* sentence) {
    if (!valid) throw Error(fmt::format("odometry: {}", sentence));
  };
  odometry::alignmentTerm(o.term);
  const auto isShare = [](double v) { return v > 0 && v <= 1; };
  require(o.width >= 48 && o.width <= 4096, "width must be 48 to 4096 pixels");
  require(o.farthest > 0 && o.farthest <= 1000, "farthest must be above 0 m");
  require(isShare(o.keyframeOverlap) && isShare(o.leastOverlap) && isShare(o.loopOverlap),
          "overlaps are above 0, at most 1");
  require(o.leastOverlap <= o.keyframeOverlap, "the least overlap must not exceed that of keyframes");
  require(o.leastLikeness >= -1 && o.leastLikeness < 1, "the least likeness must be -1 to 1");
  require(o.mostRmse > 0 && o.mostMotion > 0 && o.mostTurn > 0 && o.gap > 0,
          "mostRmse, mostMotion, mostTurn and gap must be above 0");
  require(o.loopCandidates >= 0 && o.loopKeyframes >= 1 && o.loopFeatures >= 6,
          "a loop needs at least 6 features, and keyframes at least 1 apart");
  require(o.threads >= 0 && o.threads <= 1024, "threads must be 0 to 1024");
}

RgbdTrajectory trackRgbd(const Sequence& sequence, const RgbdOptions& options, const FrameWords& words,
                         Progress* progress) {
  requireValid(options);
  requireRgbd(sequence);
  odometry::open3d();
  Progress silent;
  Progress& told = progress != nullptr ? *progress : silent;

  Tracker tracker(sequence, options, words);
  Ahead frames(sequence, options);
  told.begin("tracking", sequence.size());
  for (std::size_t i = 0; i < sequence.size(); ++i) {
    if (interrupted())
      throw Interrupted(fmt::format(
          "stopped after {} of {} frames; nothing was written, odometry starts anew", i, sequence.size()));
    tracker.add(frames.next());
    told.advance();
  }
  told.end();
  return tracker.finish(told);
}

}  // namespace estancia
