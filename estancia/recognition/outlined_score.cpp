// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <vector>

#include "estancia/recognition/pose_score.hpp"

namespace estancia {
namespace {

/// The outline of a model's support in one plane: weights of the directions in which both end, and in which
/// the plane goes on alone.
struct PlaneOutline {
  double ends = 0, goesOn = 0;

  /// What the support in the plane proves: nothing, where as much goes on as ends.
  double proof() const { return goesOn > 0 ? std::max(0.0, (ends - goesOn) / (ends + goesOn)) : 1; }
};

/// One a plane.
std::vector<PlaneOutline> outlinesOf(const std::vector<PointSupport>& points, const DenseScene& scene,
                                     const ModelExtent& extent, const cv::Affine3d& pose) {
  std::vector<PlaneOutline> outlines(scene.outline->planes().size());
  const cv::Affine3f fromScene(pose.inv());
  const Outline& outline = *scene.outline;
  for (const PointSupport& p : points) {
    const std::int32_t plane = outline.planeOf(p.scenePoint);
    if (plane < 0) continue;
    PlaneOutline& of = outlines[static_cast<std::size_t>(plane)];
    for (std::size_t d = 0; d < outline.around(p.scenePoint).size(); ++d) {
      const std::int32_t next = outline.around(p.scenePoint)[d];
      if (next == Outline::unknown) continue;
      const cv::Point3f at = next >= 0 ? scene.surface.points()[static_cast<std::size_t>(next)]
                                       : outline.place(scene.surface, p.scenePoint, d);
      if (extent.outside(fromScene * at)) (next >= 0 ? of.goesOn : of.ends) += static_cast<double>(p.weight);
    }
  }
  return outlines;
}

/// Weight of the hidden points that lie behind a plane which supported points lie before: things do not
/// pierce planes. At most as much as lies before it.
double pierced(const PosePoints& points, const DenseScene& scene, const PoseTolerances& limits) {
  constexpr double deepest = 8;  // steps; what lies deeper may be under a table
  const auto least = static_cast<float>(limits.freeSpace), tolerance = static_cast<float>(limits.offset);
  const auto most = static_cast<float>(deepest * scene.outline->step());
  double all = 0;
  for (const Outline::Plane& plane : scene.outline->planes()) {
    double before = 0, behind = 0;
    for (const PosePoints::Hidden& p : points.hidden) {
      const float height = plane.normal.dot(p.place - plane.point);
      if (height > -least || height < -most) continue;
      const std::int32_t near = scene.field.at(p.place - plane.normal * height);
      if (near == NearestField::none) continue;
      const cv::Point3f& above = scene.surface.points()[static_cast<std::size_t>(near)];
      if (std::abs(plane.normal.dot(above - plane.point)) < tolerance)
        behind += static_cast<double>(p.weight);
    }
    if (behind == 0) continue;
    for (const PointSupport& p : points.supported)
      if (plane.normal.dot(scene.surface.points()[p.scenePoint] - plane.point) > least)
        before += static_cast<double>(p.weight);
    all = std::max(all, std::min(before, behind));
  }
  return all;
}

}  // namespace

PoseScore scoreOutlined(const OrientedPoints& model, const ModelExtent& extent, const DenseScene& scene,
                        const cv::Affine3d& pose, const PoseTolerances& limits,
                        std::vector<PointSupport>* support) {
  PosePoints points;
  PoseScore score = scorePose(model, scene, pose, limits, &points);
  if (scene.outline != nullptr && extent.surface != nullptr && !points.supported.empty()) {
    const double through = pierced(points, scene, limits) / static_cast<double>(model.points.size());
    score.occluded -= through;
    score.seenThrough += through;
    const auto outlines = outlinesOf(points.supported, scene, extent, pose);
    double left = 0, all = 0;
    for (PointSupport& p : points.supported) {
      const std::int32_t plane = scene.outline->planeOf(p.scenePoint);
      all += static_cast<double>(p.weight);
      if (plane >= 0) p.weight *= static_cast<float>(outlines[static_cast<std::size_t>(plane)].proof());
      left += static_cast<double>(p.weight);
    }
    score.outlined = left / all;
    score.goesOn = score.supported * (1 - score.outlined);
    score.support *= score.outlined;
  }
  if (support != nullptr) *support = std::move(points.supported);
  return score;
}

}  // namespace estancia
