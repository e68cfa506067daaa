// Dense pose search: every match is a pose hypothesis, for scenes so noisy that hardly two matches agree.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "estancia/recognition/descriptors.hpp"
#include "estancia/recognition/pose_score.hpp"
#include "estancia/recognition/scales.hpp"

namespace estancia {

/// The points of a model with which poses are tried.
struct DenseModel {
  OrientedPoints coarse;  ///< for the many poses of all matches
  OrientedPoints fine;    ///< for the few best poses
  cv::Point3d center;
  bool closed = false;  ///< the cloud shows all sides, of which a sensor sees only some
};

/// The poses that align the local frames of each match, best first, at most `max` distinct ones.
std::vector<PoseHypothesis> posesFromLocalFrames(const SurfaceFeatures& model, const SurfaceFeatures& scene,
                                                 const std::vector<Match>& matches, const DenseModel& points,
                                                 const DenseScene& dense, const RecognitionScales& scales,
                                                 std::size_t max, int threads);

/// Refines all poses with the coarse points, and the best of these with the fine ones; their evidence is
/// the mean vote times the square root of the area. Best first, distinct ones.
std::vector<PoseHypothesis> refineDense(std::vector<PoseHypothesis> poses, const DenseModel& points,
                                        const DenseScene& dense, const RecognitionScales& scales,
                                        int threads);

/// The tolerances by which poses are verified.
PoseTolerances toleranceOf(const RecognitionScales& scales);

}  // namespace estancia
