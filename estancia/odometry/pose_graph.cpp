// SPDX-License-Identifier: Apache-2.0
#include "estancia/odometry/pose_graph.hpp"

#include "estancia/core/module_function.hpp"

namespace estancia::odometry {

PoseGraphOptimizer poseGraphOptimizer() {
  // After an exception the next call tries again.
  static const PoseGraphOptimizer optimizer = reinterpret_cast<PoseGraphOptimizer (*)()>(getModuleFunction(
      ESTANCIA_POSE_GRAPH_MODULE, ESTANCIA_POSE_GRAPH_FROM_BIN, "estanciaPoseGraphOptimizer",
      "the camera's motion cannot be estimated", "estancia-odometry"))();
  return optimizer;
}

std::vector<double> optimizePoses(std::vector<cv::Affine3d>& poses, const std::vector<PoseGraphEdge>& edges,
                                  const std::vector<bool>& free) {
  return poseGraphOptimizer()(poses, edges, free);
}

}  // namespace estancia::odometry
