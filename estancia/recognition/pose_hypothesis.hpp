// Pose hypothesis: a pose of a model in a scene, and the scene's evidence for it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <opencv2/core/affine.hpp>

#include "estancia/recognition/pose_score.hpp"
#include "estancia/recognition/verify.hpp"

namespace estancia {

struct PoseHypothesis {
  cv::Affine3d pose;        ///< T_scene_model
  std::size_t matches = 0;  ///< matches that agree on it, where matches were grouped
  PoseScore score;          ///< score of the dense search
  double evidence = 0;      ///< dense search: the score as one number
  InlierCounts counts;      ///< counts of the classical search
};

}  // namespace estancia
