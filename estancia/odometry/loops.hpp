// Loop closure: motions between keyframes that see the same at different times.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "estancia/odometry/keyframe_graph.hpp"

namespace estancia::odometry {

/// Between the ends of a loop.
constexpr std::size_t minLoopKeyframes = 4;

/// Which of the earlier keyframes are compared with a new one.
enum class LoopCandidates {
  overlapping,  ///< the keyframes that overlap it most at the current estimate
  alike         ///< the keyframes with the most similar words, at least minLoopKeyframes before it
};

/// Aligns keyframe k with at most RgbdOptions::loopCandidates earlier ones that it is not connected with, on
/// `threads` threads. Returns the motions that are to be believed.
std::vector<PoseGraphEdge> findLoops(std::size_t k, LoopCandidates candidates, const Keyframes& keyframes,
                                     const KeyframeGraph& graph, const RgbdOptions& options,
                                     std::size_t threads);

}  // namespace estancia::odometry
