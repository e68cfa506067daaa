// Every match is tried as a pose of its own: thesis 2.4.5–2.4.7 for scenes so noisy that hardly two matches
// agree.
#pragma once

#include <vector>

#include "estancia/recognition/descriptors.hpp"
#include "estancia/recognition/matching.hpp"
#include "estancia/recognition/pose_score.hpp"
#include "estancia/recognition/scales.hpp"

namespace estancia {

/// A model as it is tried.
struct DenseModel {
  OrientedPoints few, many;  ///< test points: for the many poses that matches say, for the few that are left
  cv::Point3d center;
  bool closed = false;  ///< shows all sides, of which a sensor sees but some
};

/// A pose and what the scene says of it.
struct TriedPose {
  cv::Affine3d pose;  ///< T_scene_model
  PoseScore agreement;
  double score = 0;
};

/// The pose that brings the local frames of each match together, best first, `most` different ones.
std::vector<TriedPose> posesOfFrames(const SurfaceFeatures& model, const SurfaceFeatures& scene,
                                     const std::vector<Match>& matches, const DenseModel& tried,
                                     const DenseScene& there, const RecognitionScales& scales,
                                     std::size_t most, int threads);

/// Refines poses with the few points, the best of these with the many, and scores them by evidenceFor(); best
/// first, different ones.
std::vector<TriedPose> refinePoses(std::vector<TriedPose> poses, const DenseModel& tried,
                                   const DenseScene& there, const RecognitionScales& scales, int threads);

/// The evidence that a model is there: the mean vote of its points times the root of its area, for the same
/// share of a larger surface is less likely to be chance. The area is `tried`, the number of points, 700 of
/// which count 1 (less than one where the scene has fewer points than are tried); of a closed model that of
/// the points that face the sensor.
double evidenceFor(const PoseScore& agreement, double tried, bool closed);

}  // namespace estancia
