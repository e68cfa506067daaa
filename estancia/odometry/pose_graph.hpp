// Pose graph: the poses that agree best with measured motions between them. Ceres, which finds them, brings
// CHOLMOD and a dozen other libraries, so it is in a module that is opened for the first tracker.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <opencv2/core/affine.hpp>
#include <vector>

namespace estancia::odometry {

/// A measured T_target_source.
struct PoseGraphEdge {
  std::size_t source = 0, target = 0;
  cv::Affine3d transform;
  /// Covariance of a motion (rotation, translation) that is multiplied from the left to the transform.
  cv::Matx66d covariance = cv::Matx66d::eye();
};

/// Moves `poses` (T_map_node) to the least squares of the edges, of which those that contradict the others
/// lose their weight (Cauchy's loss); the first pose stays, and those that are not `free` (empty: all are).
/// Returns for every edge how many standard deviations it is off. By Ceres, on the caller's thread alone;
/// throws as poseGraphOptimizer().
std::vector<double> optimizePoses(std::vector<cv::Affine3d>& poses, const std::vector<PoseGraphEdge>& edges,
                                  const std::vector<bool>& free = {});

using PoseGraphOptimizer = std::vector<double> (*)(std::vector<cv::Affine3d>&,
                                                   const std::vector<PoseGraphEdge>&,
                                                   const std::vector<bool>&);

/// The optimizer that optimizePoses() calls. Opens the module at the first call; throws Error
/// (missingDependency) where it cannot.
PoseGraphOptimizer poseGraphOptimizer();

}  // namespace estancia::odometry
