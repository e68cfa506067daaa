#include "estancia/recognition/verify.hpp"

#include <algorithm>
#include <cmath>

namespace estancia {

double Evidence::confidence() const {
  if (inliers == 0) return 0;
  const auto seen = static_cast<double>(inliers);
  return seen / static_cast<double>(facing - occluded) * std::sqrt(seen / static_cast<double>(facing));
}

Evidence examine(const OrientedPoints& model, const Surface& scene, const RangeImage& view,
                 const cv::Affine3d& pose, double tolerance) {
  constexpr float agreeing = 0.7F;  // cosine of the normals of the same surface
  constexpr float grazing = 0.1F;   // cosine beyond which a sensor sees nothing of a surface
  Evidence evidence;
  evidence.points = model.points.size();
  const cv::Affine3f there(pose);
  const cv::Matx33f turn = there.rotation();
  const auto reach = static_cast<float>(tolerance);
  std::vector<Neighbor> buffer;
  for (std::size_t i = 0; i < model.points.size(); ++i) {
    const cv::Point3f p = there * model.points[i], n = turn * model.normals[i];
    if (view.known() && -n.dot(p) < grazing * static_cast<float>(cv::norm(p))) continue;
    ++evidence.facing;
    const auto near = scene.neighbors().nearest(p, 1, buffer, reach);
    if (!near.empty() && n.dot(scene.normals()[near[0].index]) > agreeing) {
      ++evidence.inliers;
      continue;
    }
    if (!view.known()) continue;
    const auto depth = view.depth(p);
    if (!depth || *depth < p.z - 2 * reach)
      ++evidence.occluded;
    else if (*depth > p.z + 2 * reach)
      ++evidence.seenThrough;
  }
  return evidence;
}

bool isThere(const Evidence& evidence, double accept) {
  return evidence.inliers > 0 && evidence.confidence() >= accept &&
         5 * evidence.seenThrough <= evidence.facing && 20 * evidence.facing >= 9 * evidence.points;
}

}  // namespace estancia
