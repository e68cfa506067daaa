// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <functional>
#include <optional>

#include "estancia/core/parallel.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/odometry/tracker_impl.hpp"

namespace estancia {
namespace {

using odometry::AlignmentTarget;
using odometry::covarianceOf;
using odometry::FrameView;
using odometry::isGood;
using odometry::isTooFar;
using odometry::KeyframeGraph;
using odometry::Keyframes;
using odometry::Pyramid;

constexpr std::size_t maxTargets = 2;  // keyframes that a frame is aligned with at once
constexpr std::size_t maxNear = 16;    // keyframes among which these are picked, known to be around
constexpr std::size_t latest = 8;      // and of the latest, which hardly drift apart without loops, too
constexpr double minLoopOverlap = 0.4;
constexpr int guessFeatures = 12;  // features that must agree on a guess, which is verified then

/// Whether another pose would lead an alignment to the same.
auto isNear(const cv::Affine3d& pose) {
  return [&pose](const cv::Affine3d& other) {
    const cv::Affine3d motion = other.inv() * pose;
    return cv::norm(motion.translation()) + angleOf(motion) < 0.01;
  };
}

/// The earlier keyframes that overlap keyframe k most where they are now.
std::vector<std::size_t> overlapping(std::size_t k, const Keyframes& keyframes, const KeyframeGraph& graph,
                                     const RgbdOptions& options) {
  constexpr int glance = 4;  // so many pixels are left out in a first look, which halves the threshold
  std::vector<std::pair<double, std::size_t>> found;
  for (std::size_t o = 0; o < k; ++o) {
    if (graph.connects(k, o)) continue;
    const cv::Affine3d motion = keyframes.pose(o).inv() * keyframes.pose(k);
    if (cv::norm(motion.translation()) > options.maxDepth) continue;
    const odometry::CoarseView &source = keyframes[k].coarse, &target = keyframes[o].coarse;
    if (predictedOverlap(source, target, motion, glance) < minLoopOverlap / 2) continue;
    const double overlap = predictedOverlap(source, target, motion);
    if (overlap >= minLoopOverlap) found.emplace_back(-overlap, o);
  }
  return odometry::smallest(std::move(found), static_cast<std::size_t>(options.loopCandidates));
}

/// The earlier keyframes with the most similar words.
std::vector<std::size_t> alike(std::size_t k, const Keyframes& keyframes, const KeyframeGraph& graph,
                               const RgbdOptions& options) {
  std::vector<std::size_t> found =
      keyframes.withWordsOf(k, odometry::minLoopKeyframes, static_cast<std::size_t>(options.loopCandidates));
  std::erase_if(found, [&](std::size_t o) { return graph.connects(k, o); });
  return found;
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

/// The motion of keyframe k to another one, if it is to be believed. Where words proposed it, features must
/// agree on a motion first, because any wall aligns with any other.
std::optional<RgbdTracker::Impl::PoseGraphEdge> RgbdTracker::Impl::loop(std::size_t k, std::size_t other,
                                                                        bool byWords,
                                                                        const Pyramid& source) const {
  const odometry::Keyframe &a = keyframes[k], &b = keyframes[other];
  std::optional<cv::Affine3d> guess = b.pose.inv() * a.pose;
  if (byWords) guess = guessFromFeatures(a.features, b.features, options.minLoopFeatures);
  if (!guess) return std::nullopt;
  const Pyramid target = keyframes.newPyramid(other);
  const AlignmentTarget single{&target, cv::Affine3d::Identity()};
  const Alignment found = align(source, {&single, 1}, *guess, how);
  if (!isGood(found, minLoopOverlap)) return std::nullopt;
  return PoseGraphEdge{k, other, found.transform, covarianceOf(found.information)};
}

/// Aligns keyframe k with earlier ones that it is not connected with, and moves all to the optimum; once more
/// where that moved it so far that other keyframes may overlap it now.
void RgbdTracker::Impl::closeLoops(std::size_t k) {
  constexpr double far = 0.05;  // [m]; an alignment finds what is off by as much again
  bool isMoved = false, isOptimal = !graph.isOverdetermined(k);
  const auto optimize = [&] {
    const cv::Affine3d before = keyframes.pose(k);
    graph.optimize(keyframes);
    isMoved = shiftOfScene(before.inv() * keyframes.pose(k), keyframes[k].coarse) > far;
    isOptimal = true;
  };
  const auto close = [&](const std::vector<std::size_t>& others, bool byWords) {
    if (others.empty()) return;
    const Pyramid source = keyframes.newPyramid(k);
    std::vector<std::optional<PoseGraphEdge>> found(others.size());
    inParallel(others.size(), std::min(threads, others.size()),
               [&](std::size_t i) { found[i] = loop(k, others[i], byWords, source); });
    for (const auto& edge : found)
      if (edge) graph.add(*edge, KeyframeGraph::Kind::loop);
    if (std::ranges::any_of(found, [](const auto& edge) { return edge.has_value(); })) optimize();
  };
  if (options.loopCandidates > 0) {
    close(alike(k, keyframes, graph, options), true);
    close(overlapping(k, keyframes, graph, options), false);
    if (isMoved) close(overlapping(k, keyframes, graph, options), false);
  }
  if (!isOptimal) optimize();
}

}  // namespace estancia
