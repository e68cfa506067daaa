// Loop closure: motions between keyframes that see the same, and the poses that agree with all of them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "estancia/core/progress.hpp"
#include "estancia/odometry/keyframes.hpp"
#include "estancia/odometry/pose_graph.hpp"

namespace estancia::odometry {

/// Whether an alignment is to be believed.
bool isGood(const Alignment& alignment, double minOverlap, const RgbdOptions& options);

/// Aligns keyframes that overlap where they are now or that have similar words, and moves all keyframes to
/// the optimum of these motions, of the `tracked` and of the `assumed` ones; then again, as better poses tell
/// more overlaps. Returns the motions that agree with the result, of keyframes that were not tracked from one
/// to the other; none when RgbdOptions::loopCandidates is 0.
std::vector<PoseGraphEdge> closeLoops(Keyframes& keyframes, const std::vector<PoseGraphEdge>& tracked,
                                      const std::vector<PoseGraphEdge>& assumed, const RgbdOptions& options,
                                      Progress& progress);

/// The nodes that edges connect with each other, directly or not: the number of its part for every node.
std::vector<std::size_t> partsOf(std::size_t nodes, const std::vector<PoseGraphEdge>& edges);

}  // namespace estancia::odometry
