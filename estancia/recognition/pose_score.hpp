// Pose score: how well a scene supports a model in a pose, fast enough for every match.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/core/affine.hpp>
#include <vector>

#include "estancia/recognition/nearest_field.hpp"
#include "estancia/recognition/range_image.hpp"
#include "estancia/recognition/refine.hpp"
#include "estancia/recognition/surface.hpp"

namespace estancia {

/// A scene in which poses are scored.
struct DenseScene {
  const Surface& surface;
  const NearestField& field;  ///< field of surface.points()
  const RangeImage& view;
  const std::vector<cv::Matx33f>* gradients = nullptr;  ///< colorGradients(surface), where colors count
};

/// Tolerances of the pose score.
struct PoseTolerances {
  /// Largest distance of a supported point across the scene's surface [m].
  double offset = 0;
  /// Distance along the ray from which on a point is in front of a surface or behind [m].
  double freeSpace = 0;
  /// Smallest dot product of the normals of a supported point and its surface.
  double minDot = 0.7;
  /// Largest colorDifference() of a supported point from its surface, if both have colors; 0: any.
  double color = 0;
};

/// Shares of the weights of all points that were tried.
struct PoseScore {
  double facing = 0;       ///< facing the sensor: could be visible
  double supported = 0;    ///< facing points on a scene surface with a similar normal
  double seenThrough = 0;  ///< facing points in free space: in front of what the sensor measured
  double occluded = 0;     ///< facing points behind something
  double mismatched = 0;   ///< facing points near a surface that does not fit
  double behind = 0;       ///< not facing the sensor, in free space: the sensor would see the other side
  double support = 0;      ///< supported, each weighted from 1 (no offset, no angle) to 0 at the tolerances
  std::size_t points = 0;  ///< number of supported points

  /// Mean vote of the points: +support, -1 in free space, -1/4 when mismatched. In [−1, 1].
  double vote() const { return support - seenThrough - behind - 0.25 * mismatched; }
};

/// Cosine of two unit normals; of lines, unless `sided`: without a view, the side is unknown.
inline float cosineOf(const cv::Point3f& a, const cv::Point3f& b, bool sided) {
  const float dot = a.dot(b);
  return sided ? dot : std::abs(dot);
}

/// Faster than countInliers() of verify.hpp, for every match: it looks neighbors up instead of searching, and
/// weights how well points fit instead of counting those within a tolerance.
PoseScore scorePose(const OrientedPoints& model, const DenseScene& scene, const cv::Affine3d& pose,
                    const PoseTolerances& limits);

/// A supported point of a model.
struct PointSupport {
  std::uint32_t scenePoint;  ///< index of the point of the surface that supports it
  float weight;              ///< its part of PoseScore::support, not normalized
};
/// Support of each point for a pose, as scorePose() counts it.
std::vector<PointSupport> supportOf(const OrientedPoints& model, const DenseScene& scene,
                                    const cv::Affine3d& pose, const PoseTolerances& limits);

/// Weights that reduce the influence of large planar parts, or a table top would match the side of every box:
/// the number of points whose normals differ by less than 20°, to the power −0.5, scaled to a mean of 1.
void balanceNormals(OrientedPoints& model);

struct FieldRefinement {
  double firstReach = 0, lastReach = 0;  ///< [m] across the surface, in the first and the last round
  int rounds = 10;
  double color = 0;  ///< tolerance of the ColorTerm; 0: none
};

/// Point-to-plane ICP with weights that fall to 0 at the reach, and a ColorTerm. Unlike refinePose() it looks
/// neighbors up in the field, and limits only their distance across the surface, because the spacing of a
/// mean surface exceeds its error.
cv::Affine3d refineInField(const OrientedPoints& model, const cv::Point3d& center, const DenseScene& scene,
                           const cv::Affine3d& pose, const FieldRefinement& options);

}  // namespace estancia
