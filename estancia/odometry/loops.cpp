// SPDX-License-Identifier: Apache-2.0
#include "estancia/odometry/loops.hpp"

#include <algorithm>
#include <optional>

#include "estancia/core/parallel.hpp"

namespace estancia::odometry {
namespace {

constexpr double minLoopOverlap = 0.4;

/// The earlier keyframes that overlap keyframe k most where they are now.
std::vector<std::size_t> overlapping(std::size_t k, const Keyframes& keyframes, const KeyframeGraph& graph,
                                     const RgbdOptions& options) {
  constexpr int glance = 4;  // so many pixels are left out in a first look, which halves the threshold
  std::vector<std::pair<double, std::size_t>> found;
  for (std::size_t o = 0; o < k; ++o) {
    if (graph.connects(k, o)) continue;
    const cv::Affine3d motion = keyframes.pose(o).inv() * keyframes.pose(k);
    if (cv::norm(motion.translation()) > options.maxDepth) continue;
    const CoarseView &source = keyframes[k].coarse, &target = keyframes[o].coarse;
    if (predictedOverlap(source, target, motion, glance) < minLoopOverlap / 2) continue;
    const double overlap = predictedOverlap(source, target, motion);
    if (overlap >= minLoopOverlap) found.emplace_back(-overlap, o);
  }
  std::ranges::sort(found);
  std::vector<std::size_t> most;
  for (std::size_t i = 0; i < found.size() && i < static_cast<std::size_t>(options.loopCandidates); ++i)
    most.push_back(found[i].second);
  return most;
}

std::vector<std::size_t> alike(std::size_t k, const Keyframes& keyframes, const KeyframeGraph& graph,
                               const RgbdOptions& options) {
  std::vector<std::size_t> found =
      keyframes.withWordsOf(k, minLoopKeyframes, static_cast<std::size_t>(options.loopCandidates));
  std::erase_if(found, [&](std::size_t o) { return graph.connects(k, o); });
  return found;
}

/// Where words proposed it, features must agree on a motion first, because any wall aligns with any other.
std::optional<PoseGraphEdge> verified(std::size_t k, std::size_t other, LoopCandidates candidates,
                                      const Pyramid& source, const Keyframes& keyframes,
                                      const RgbdOptions& options) {
  const Keyframe &a = keyframes[k], &b = keyframes[other];
  std::optional<cv::Affine3d> guess = b.pose.inv() * a.pose;
  if (candidates == LoopCandidates::alike)
    guess = guessFromFeatures(a.features, b.features, options.minLoopFeatures);
  if (!guess) return std::nullopt;
  const Pyramid target = keyframes.newPyramid(other);
  const AlignmentTarget single{&target, cv::Affine3d::Identity()};
  AlignmentOptions how;
  how.term = alignmentTerm(options.term);
  const Alignment found = align(source, {&single, 1}, *guess, how);
  if (!isGood(found, minLoopOverlap)) return std::nullopt;
  return PoseGraphEdge{k, other, found.transform, covarianceOf(found.information)};
}

}  // namespace

std::vector<PoseGraphEdge> findLoops(std::size_t k, LoopCandidates candidates, const Keyframes& keyframes,
                                     const KeyframeGraph& graph, const RgbdOptions& options,
                                     std::size_t threads) {
  const std::vector<std::size_t> others = candidates == LoopCandidates::alike
                                              ? alike(k, keyframes, graph, options)
                                              : overlapping(k, keyframes, graph, options);
  if (others.empty()) return {};
  const Pyramid source = keyframes.newPyramid(k);
  std::vector<std::optional<PoseGraphEdge>> found(others.size());
  inParallel(others.size(), std::min(threads, others.size()), [&](std::size_t i) {
    found[i] = verified(k, others[i], candidates, source, keyframes, options);
  });
  std::vector<PoseGraphEdge> loops;
  for (const auto& edge : found)
    if (edge) loops.push_back(*edge);
  return loops;
}

}  // namespace estancia::odometry
