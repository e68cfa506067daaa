// Pose refinement: iterative closest points, point to plane (thesis 2.4.6).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/affine.hpp>
#include <vector>

#include "estancia/recognition/surface.hpp"

namespace estancia {

/// Points [m] with unit normals of a model that is tried in a scene. `weights` are those of the pose score;
/// empty: all 1.
struct OrientedPoints {
  std::vector<cv::Point3f> points, normals;
  std::vector<float> weights;
  std::vector<cv::Vec3f> lab = {};  ///< CIELAB; empty: no colors
};

/// About `count` points, evenly spread over a surface; all when it has no more.
OrientedPoints spreadPoints(const Surface& surface, std::size_t count);

/// One point a voxel of edge `spacing` [m].
OrientedPoints spreadPointsBy(const Surface& surface, double spacing);

/// The pose T_scene_model near `pose` that brings the model's points onto the planes of the nearest scene
/// points (Chen and Medioni 1992): Gauss-Newton with Tukey's weights, which ignore partners further away than
/// `reach` [m] or rotated by more than 60°. Stops when the pose has converged, at most after `rounds`.
/// Returns `pose` when too few points have a partner. Unlike refineInField() it uses exact nearest neighbors,
/// and the reach limits the distance from point to point.
cv::Affine3d refinePose(const OrientedPoints& model, const Surface& scene, const cv::Affine3d& pose,
                        double reach, int rounds);

}  // namespace estancia
