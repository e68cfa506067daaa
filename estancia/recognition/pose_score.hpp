// Pose hypotheses: their score by the scene, and the dense search, which tries one for every match.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <opencv2/core/affine.hpp>
#include <utility>
#include <vector>

#include "estancia/recognition/descriptors.hpp"
#include "estancia/recognition/nearest_field.hpp"
#include "estancia/recognition/outline.hpp"
#include "estancia/recognition/range_image.hpp"
#include "estancia/recognition/scales.hpp"
#include "estancia/recognition/surface.hpp"
#include "estancia/recognition/verify.hpp"

namespace estancia {

/// How the color changes along a surface [1/m]: row c is the gradient of channel c of CIELAB in the tangent
/// plane of a point, by least squares over the points within `radius` [m]. One a point; empty when the
/// surface has no colors.
std::vector<cv::Matx33f> colorGradients(const Surface& surface, double radius, int threads);

/// A scene in which poses are scored.
struct DenseScene {
  const Surface& surface;
  const NearestField& field;  ///< field of surface.points()
  const RangeImage& view;
  const std::vector<cv::Matx33f>* gradients = nullptr;  ///< colorGradients(surface), where colors count
  const RangeImage* measured = nullptr;                 ///< the points themselves: edges to a pixel
  const Outline* outline = nullptr;                     ///< edges and planes, where they count
};

/// Tolerances of the pose score.
struct PoseTolerances {
  /// Largest distance of a supported point across the scene's surface [m].
  double offset = 0;
  /// Distance along the ray from which on a point is in front of a surface or behind [m].
  double freeSpace = 0;
  /// Smallest dot product of the normals of a supported point and its surface.
  double minDot = 0.7;
  /// Largest difference of a supported point's color from its surface's, if both have colors; 0: any. In
  /// CIELAB, lightness counts half, as light changes it most (CMC l:c = 2:1, Clarke, McDonald, Rigg 1984).
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
  double outlined = 1;     ///< share of the support that is not explained by larger planes
  double goesOn = 0;   ///< supported by planes that go on beyond the outline: (1 − outlined) of supported
  double support = 0;  ///< supported, each weighted from 1 (no offset, no angle) to 0 at the tolerances
  std::size_t points = 0;  ///< number of supported points

  /// Mean vote of the points: +support, −1 in free space and where a plane goes on beyond the outline, −1/4
  /// when mismatched. In [−1, 1].
  double vote() const { return support - seenThrough - behind - goesOn - 0.25 * mismatched; }
};

/// Cosine of two unit normals; of lines, unless `sided`: without a view, the side is unknown.
inline float cosineOf(const cv::Point3f& a, const cv::Point3f& b, bool sided) {
  const float dot = a.dot(b);
  return sided ? dot : std::abs(dot);
}

/// A supported point of a model.
struct PointSupport {
  std::uint32_t scenePoint;  ///< index of the point of the surface that supports it
  float weight;              ///< its part of PoseScore::support, not normalized
};

/// The points that a score is made of.
struct PosePoints {
  struct Hidden {
    cv::Point3f place;  ///< in the scene [m]
    float weight;
  };
  std::vector<PointSupport> supported;
  std::vector<Hidden> hidden;  ///< behind something
};

/// Faster than countInliers() of verify.hpp, for every match: it looks neighbors up instead of searching, and
/// weights how well points fit instead of counting those within a tolerance. With `list` more exactly: what
/// is in free space by DenseScene::measured is no support, though the surface ends near it.
PoseScore scorePose(const OrientedPoints& model, const DenseScene& scene, const cv::Affine3d& pose,
                    const PoseTolerances& limits, PosePoints* list = nullptr);

/// scorePose(), after the consistency of scene and edges of Vidal et al. (Sensors 2018): a face within a
/// larger plane (DenseScene::outline) speaks against the pose, as far as the plane goes on beyond the model's
/// outline. What a plane hides although the model begins before it is seen through. `support`, when
/// given, becomes that of each point.
PoseScore scoreOutlined(const OrientedPoints& model, const ModelExtent& extent, const DenseScene& scene,
                        const cv::Affine3d& pose, const PoseTolerances& limits,
                        std::vector<PointSupport>* support = nullptr);

/// Weights that reduce the influence of large planar parts, or a table top would match the side of every box:
/// the number of points whose normals differ by less than 20°, to the power −0.5, scaled to a mean of 1.
void balanceNormals(OrientedPoints& model);

struct FieldRefinement {
  double firstReach = 0, lastReach = 0;  ///< [m] across the surface, in the first and the last round
  int rounds = 10;
  double color = 0;  ///< difference of colors that weighs as much as a distance of the reach; 0: none
};

/// Point-to-plane ICP with weights that fall to 0 at the reach, and a term of colors (Park, Zhou, Koltun:
/// Colored point cloud registration revisited, 2017). Unlike refinePose() it looks
/// neighbors up in the field, and limits only their distance across the surface, because the spacing of a
/// mean surface exceeds its error.
cv::Affine3d refineInField(const OrientedPoints& model, const cv::Point3d& center, const DenseScene& scene,
                           const cv::Affine3d& pose, const FieldRefinement& options);

struct PoseHypothesis {
  cv::Affine3d pose;        ///< T_scene_model
  std::size_t matches = 0;  ///< matches that agree on it, where matches were grouped
  PoseScore score;          ///< score of the dense search
  double evidence = 0;      ///< dense search: the score as one number
  InlierCounts counts;      ///< counts of the classical search
};

constexpr double anyRotation = -2;  ///< less than any cosine

/// The first `max` of `poses`, best first, each a struct with a T_scene_model called `pose`, without those
/// that are similar to a better one: at the model's `center` less than `minDistance` [m] away, and rotated by
/// less than the angle whose cosine is `minCosine`.
template <class Posed>
std::vector<Posed> distinctPoses(std::vector<Posed> poses, const cv::Point3d& center, double minDistance,
                                 double minCosine,
                                 std::size_t max = std::numeric_limits<std::size_t>::max()) {
  const double minTrace = 1 + 2 * minCosine;
  std::vector<Posed> kept;
  std::vector<cv::Point3d> centers;
  for (Posed& pose : poses) {
    if (kept.size() >= max) break;
    const cv::Point3d at = pose.pose * center;
    bool similar = false;
    for (std::size_t i = 0; i < kept.size() && !similar; ++i) {
      const cv::Point3d d = at - centers[i];
      if (d.dot(d) >= minDistance * minDistance) continue;
      // trace(Aᵀ B) is the sum of the products of their elements
      similar = kept[i].pose.rotation().dot(pose.pose.rotation()) > minTrace;
    }
    if (similar) continue;
    centers.push_back(at);
    kept.push_back(std::move(pose));
  }
  return kept;
}

/// The points of a model with which poses are tried.
struct DenseModel {
  OrientedPoints coarse;  ///< for the many poses of all matches
  OrientedPoints fine;    ///< for the few best poses
  std::size_t area = 0;   ///< number of points as dense as those of a small model: evidence grows with it
  cv::Point3d center;
  bool closed = false;  ///< the cloud shows all sides, of which a sensor sees only some
  ModelExtent extent;   ///< without a surface: outlines do not count
};

/// The poses that align the local frames of each match, best first, at most `max` distinct ones. Every match
/// is a hypothesis, for scenes so noisy that hardly two matches agree.
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
