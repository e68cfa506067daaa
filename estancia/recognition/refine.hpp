// A pose made exact: iterative closest points (thesis 2.4.6).
#pragma once

#include <opencv2/core/affine.hpp>
#include <vector>

#include "estancia/recognition/surface.hpp"

namespace estancia {

/// Points [m] with unit normals, as a model is tried in a scene. `weights` say how much a point counts where
/// agreement is asked for; empty: all 1.
struct OrientedPoints {
  std::vector<cv::Point3f> points, normals;
  std::vector<float> weights;
};

/// About `count` points of a surface, evenly spread over it, all when it has no more.
OrientedPoints spreadPoints(const Surface& surface, std::size_t count);

/// One point a cell of so many meters.
OrientedPoints spreadPointsBy(const Surface& surface, double spacing);

/// The pose T_scene_model near `pose` that brings the model's points onto the planes of the scene points
/// nearest to them (Chen and Medioni 1992): Gauss-Newton with Tukey's weights, so that partners further away
/// than `reach` [m] or turned away by more than 60° have no say. Stops when the pose stands still, at most
/// after `rounds`. Returns `pose` when too few points have a partner. Unlike
/// refineInField() it asks for the very nearest points, and its reach is from point to point.
cv::Affine3d refinePose(const OrientedPoints& model, const Surface& scene, const cv::Affine3d& pose,
                        double reach, int rounds);

}  // namespace estancia
