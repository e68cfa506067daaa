// How well a scene agrees with a model in a pose, point by point: quick enough to try every match.
#pragma once

#include <cstddef>
#include <opencv2/core/affine.hpp>
#include <vector>

#include "estancia/recognition/nearest_field.hpp"
#include "estancia/recognition/range_image.hpp"
#include "estancia/recognition/refine.hpp"
#include "estancia/recognition/surface.hpp"

namespace estancia {

/// A scene as poses are tried in it.
struct DenseScene {
  const Surface& surface;
  const NearestField& field;  ///< of surface.points()
  const RangeImage& view;
};

/// What is told apart.
struct PoseTolerances {
  double offset = 0;      ///< [m] across the scene's surface, from which on a point no longer agrees
  double freeSpace = 0;   ///< [m] along the ray, from which on a point is in front of a surface or behind it
  double leastDot = 0.7;  ///< cosine of the angle between normals, likewise
};

/// In shares of the weights of all points that were tried.
struct PoseScore {
  double facing = 0;       ///< turned to the sensor: what could be seen
  double supported = 0;    ///< of these, with a surface there that is turned the same way
  double seenThrough = 0;  ///< of these, in front of what the sensor saw: there can be nothing
  double occluded = 0;     ///< of these, behind something
  double mismatched = 0;   ///< of these, with a surface near that is not the model's
  double behind = 0;   ///< turned away, and nothing stands before them: the sensor would see the other side
  double support = 0;  ///< supported, each by 1 when offset and angle are 0, down to 0 at the limits
  std::size_t points = 0;  ///< that are supported

  /// Mean vote of the points: for by support, against where the scene is seen through them, a quarter against
  /// where the surface is elsewhere. In [−1, 1].
  double vote() const { return support - seenThrough - behind - 0.25 * mismatched; }
};

/// Beside examine() in verify.hpp because it is asked for every match: it looks points up instead of
/// searching for them, and weighs how well they fit instead of counting those within a tolerance.
PoseScore scorePose(const OrientedPoints& model, const DenseScene& scene, const cv::Affine3d& pose,
                    const PoseTolerances& limits);

/// Weights such that parts that face one way together count by a power of their size below 1, or a table's
/// top would agree with the side of every box: the number of points whose normals differ by less than 20°, to
/// the power −0.5, scaled to a mean of 1.
void balanceNormals(OrientedPoints& model);

struct FieldRefinement {
  double firstReach = 0, lastReach = 0;  ///< [m] across the surface, in the first and the last round
  int rounds = 10;
};

/// Iterative closest points, point to plane, with weights that fall to 0 at the reach. Beside refinePose()
/// because partners come from the field and their reach is across the surface alone: points of a mean surface
/// lie further apart than it is wrong.
cv::Affine3d refineInField(const OrientedPoints& model, const cv::Point3d& center, const DenseScene& scene,
                           const cv::Affine3d& pose, const FieldRefinement& options);

}  // namespace estancia
