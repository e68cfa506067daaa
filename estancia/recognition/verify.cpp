// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/verify.hpp"

#include <cmath>

namespace estancia {

double InlierCounts::confidence() const {
  if (inliers == 0) return 0;
  const auto count = static_cast<double>(inliers);
  return count / static_cast<double>(facing - occluded) * std::sqrt(count / static_cast<double>(facing));
}

InlierCounts countInliers(const OrientedPoints& model, const Surface& scene, const RangeImage& view,
                          const cv::Affine3d& pose, double tolerance) {
  constexpr float minDot = 0.7F;   // cosine of normals of the same surface
  constexpr float grazing = 0.1F;  // cosine below which a sensor measures nothing of a surface
  InlierCounts counts;
  counts.points = model.points.size();
  const cv::Affine3f transform(pose);
  const cv::Matx33f rotation = transform.rotation();
  const auto reach = static_cast<float>(tolerance);
  std::vector<Neighbor> buffer;
  for (std::size_t i = 0; i < model.points.size(); ++i) {
    const cv::Point3f p = transform * model.points[i], n = rotation * model.normals[i];
    if (view.known() && -n.dot(p) < grazing * static_cast<float>(cv::norm(p))) continue;
    ++counts.facing;
    const auto near = scene.neighbors().nearest(p, 1, buffer, reach);
    if (!near.empty() && n.dot(scene.normals()[near[0].index]) > minDot) {
      ++counts.inliers;
      continue;
    }
    if (!view.known()) continue;
    const auto depth = view.depth(p);
    if (!depth || *depth < p.z - 2 * reach)
      ++counts.occluded;
    else if (*depth > p.z + 2 * reach)
      ++counts.seenThrough;
  }
  return counts;
}

bool isAccepted(const InlierCounts& counts, double accept) {
  return counts.inliers > 0 && counts.confidence() >= accept && 5 * counts.seenThrough <= counts.facing &&
         20 * counts.facing >= 9 * counts.points;
}

}  // namespace estancia
