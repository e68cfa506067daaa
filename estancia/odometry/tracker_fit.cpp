// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <functional>

#include "estancia/core/pose.hpp"
#include "estancia/odometry/tracker_impl.hpp"

namespace estancia {
namespace {

using odometry::AlignmentTarget;
using odometry::FrameView;
using odometry::isGood;
using odometry::isTooFar;

constexpr std::size_t maxTargets = 2;  // keyframes that a frame is aligned with at once
constexpr std::size_t maxNear = 16;    // keyframes among which these are picked, known to be around
constexpr std::size_t latest = 8;      // and of the latest, which hardly drift apart without loops, too
constexpr int guessFeatures = 12;      // features that must agree on a guess, which is verified then

/// Whether another pose would lead an alignment to the same.
auto isNear(const cv::Affine3d& pose) {
  return [&pose](const cv::Affine3d& other) {
    const cv::Affine3d motion = other.inv() * pose;
    return cv::norm(motion.translation()) + angleOf(motion) < 0.01;
  };
}

}  // namespace

/// T_map_frame as the motion so far goes on.
cv::Affine3d RgbdTracker::Impl::steady(std::size_t frame) const {
  return lastPose * odometry::times(velocity, static_cast<double>(frame - lastFrame));
}

/// T_map_frame predicted by the prior, else by continuing the motion so far.
cv::Affine3d RgbdTracker::Impl::predicted(std::size_t frame) const {
  if (const auto motion = prior.transform(lastFrame, frame)) return lastPose * *motion;
  return steady(frame);
}

/// Guesses of T_map_frame without a look at features: the prior, the motion so far, none.
std::vector<cv::Affine3d> RgbdTracker::Impl::guessesByMotion(std::size_t frame) const {
  return {predicted(frame), steady(frame), lastPose};
}

/// Guesses of T_map_view by matched features.
std::vector<cv::Affine3d> RgbdTracker::Impl::guessesByFeatures(const FrameView& view) const {
  std::vector<cv::Affine3d> found;
  const auto& keyframe = keyframes[current];
  if (const auto motion = guessFromFeatures(view.features, keyframe.features, guessFeatures))
    found.push_back(keyframe.pose * *motion);
  if (lastFrame != keyframe.frame)
    if (const auto motion = guessFromFeatures(view.features, last->features, guessFeatures))
      found.push_back(lastPose * *motion);
  return found;
}

/// Aligns the view with the keyframes around the guess.
std::optional<RgbdTracker::Impl::Found> RgbdTracker::Impl::refined(const FrameView& view,
                                                                   const cv::Affine3d& guess,
                                                                   std::size_t finest) const {
  std::vector<std::size_t> near = graph.around(current, maxNear);
  near.push_back(current);
  for (std::size_t k = keyframes.size() - std::min(keyframes.size(), latest); k < keyframes.size(); ++k)
    if (std::ranges::find(near, k) == near.end()) near.push_back(k);
  const auto around = keyframes.overlapped(coarseOf(view.pyramid), guess, near, maxTargets);
  if (around.empty()) return std::nullopt;
  std::vector<AlignmentTarget> targets;
  for (const std::size_t k : around) targets.push_back({&keyframes.pyramid(k), keyframes.pose(k)});
  odometry::AlignmentOptions until = how;
  until.finest = finest;
  const Alignment a = align(view.pyramid, targets, guess, until);
  if (!a.solved) return std::nullopt;
  return Found{around.front(), a};
}

/// Takes the guess that fits best on the coarsest level, and refines it.
std::optional<RgbdTracker::Impl::Found> RgbdTracker::Impl::fit(const FrameView& view,
                                                               std::size_t frame) const {
  std::vector<std::pair<double, cv::Affine3d>> ranked;
  std::vector<cv::Affine3d> tried;
  const auto rank = [&](const std::vector<cv::Affine3d>& guesses) {
    for (const cv::Affine3d& guess : guesses) {
      if (isTooFar(lastPose.inv() * guess) || std::ranges::any_of(tried, isNear(guess))) continue;
      tried.push_back(guess);
      if (const auto found = refined(view, guess, view.pyramid.size() - 1))
        ranked.emplace_back(found->alignment.agreement, found->alignment.transform);
    }
    std::ranges::stable_sort(ranked, std::greater(), &std::pair<double, cv::Affine3d>::first);
  };
  rank(guessesByMotion(frame));
  // A guess that agrees as much as a frame without need of a keyframe is clear without features.
  if (ranked.empty() || ranked.front().first < options.keyframeOverlap) rank(guessesByFeatures(view));
  for (const auto& [agreement, guess] : ranked) {
    const auto found = refined(view, guess, 0);
    if (found && isGood(found->alignment) && !isTooFar(lastPose.inv() * found->alignment.transform))
      return found;
  }
  return std::nullopt;
}

/// Tries the keyframe where the camera was lost, and those with similar words. Features must agree, because
/// any wall aligns with any other.
std::optional<RgbdTracker::Impl::Found> RgbdTracker::Impl::relocalize(Current& now) const {
  std::vector<std::size_t> candidates{current};
  for (const std::size_t k :
       keyframes.withWords(now.words(), static_cast<std::size_t>(options.loopCandidates)))
    if (k != current) candidates.push_back(k);
  for (const std::size_t k : candidates)
    if (const auto guess =
            guessFromFeatures(now.view.features, keyframes[k].features, options.minLoopFeatures)) {
      const AlignmentTarget target{&keyframes.pyramid(k), keyframes.pose(k)};
      const Alignment a = align(now.view.pyramid, {&target, 1}, keyframes.pose(k) * *guess, how);
      if (isGood(a)) return Found{k, a};
    }
  return std::nullopt;
}

}  // namespace estancia
