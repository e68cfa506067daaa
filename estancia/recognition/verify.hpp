// Classical refinement and verification of poses (thesis 2.4.6, 2.4.7): does the scene support a model?
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/affine.hpp>
#include <span>
#include <vector>

#include "estancia/recognition/range_image.hpp"
#include "estancia/recognition/surface.hpp"

namespace estancia {

/// The pose T_scene_model near `pose` that brings the model's points onto the planes of the nearest scene
/// points (Chen and Medioni 1992): Gauss-Newton with Tukey's weights, which ignore partners further away than
/// `reach` [m] or rotated by more than 60°. Stops when the pose has converged, at most after `rounds`.
/// Returns `pose` when too few points have a partner. Unlike refineInField() it uses exact nearest neighbors,
/// and the reach limits the distance from point to point.
cv::Affine3d refinePose(const OrientedPoints& model, const Surface& scene, const cv::Affine3d& pose,
                        double reach, int rounds);

/// Support for a model in a pose: numbers of visible, inlying, occluded and free-space-violating points.
struct InlierCounts {
  std::size_t points = 0;       ///< points of the model
  std::size_t facing = 0;       ///< points facing the sensor: could be visible
  std::size_t inliers = 0;      ///< facing points with a scene point near that has a similar normal
  std::size_t occluded = 0;     ///< facing points behind something, or where the sensor measured nothing
  std::size_t seenThrough = 0;  ///< facing points in free space: in front of what the sensor measured

  /// The inlying share of what should be visible (facing − occluded), times the square root of the inlying
  /// share of what faces the sensor, because a small part of a hidden model may agree by chance. In [0, 1].
  double confidence() const;
};

/// With exact nearest neighbors; scorePose() is the quick approximation.
InlierCounts countInliers(const OrientedPoints& model, const Surface& scene, const RangeImage& view,
                          const cv::Affine3d& pose, double tolerance);

/// The simple check: the confidence is at least `accept`, less than a fifth of the visible model is in free
/// space, and at least 45 % of the model face the sensor, as its cloud was recorded by one.
bool isAccepted(const InlierCounts& counts, double accept);

/// Global hypothesis verification (Aldoma, Tombari, Di Stefano, Vincze 2012): the set of hypotheses that
/// together explains most of the scene with the fewest model points without scene support, scene points
/// explained twice, and unexplained points on a smooth part of the scene that is partly explained; by
/// simulated annealing. `smoothParts` is smoothPartsOf(scene). Model and scene should have the same point
/// spacing. `tolerance` [m] is that between a scene point and the model point that explains it. Returns
/// whether each pose belongs to it.
std::vector<bool> verifyGlobally(const OrientedPoints& model, const Surface& scene, const RangeImage& view,
                                 std::span<const int> smoothParts, std::span<const cv::Affine3d> poses,
                                 double tolerance);

/// Smooth segments of a surface: for each point the number of its part, 0 for small parts. Points of a part
/// are connected by neighbors within `reach` [m] whose normals differ by less than 0.2 rad.
std::vector<int> smoothPartsOf(const Surface& surface, double reach, int threads = 1);

}  // namespace estancia
