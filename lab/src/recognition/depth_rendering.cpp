// SPDX-License-Identifier: Apache-2.0
#include "recognition/depth_rendering.hpp"

#include <algorithm>
#include <cmath>

#include "estancia/cloud/neighbors.hpp"
#include "estancia/cloud/normals.hpp"
#include "estancia/cloud/resolution.hpp"
#include "estancia/core/error.hpp"

namespace estancia::experiments {

Discs discsOf(const PointCloud& cloud) {
  constexpr double perSpacing = 1.8, perRadius = 4;  // multiples of the points' spacing
  Discs discs;
  const bool oriented = cloud.normals.size() == cloud.points.size();
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    if (!isFinite(cloud.points[i])) continue;
    discs.points.push_back(cloud.points[i]);
    if (oriented) discs.normals.push_back(cloud.normals[i]);
  }
  if (discs.points.empty())
    throw Error(ErrorCode::invalidInput, "a model without points; give clouds of objects");
  const Neighbors neighbors(discs.points);
  const double spacing = spacingOf(neighbors);
  if (!oriented) discs.normals = estimateNormals(discs.points, neighbors, {.radius = perRadius * spacing});
  discs.radius = perSpacing * spacing;
  for (const cv::Point3f& p : discs.points) discs.center += cv::Vec3d(cv::Point3d(p));
  discs.center *= 1 / static_cast<double>(discs.points.size());
  return discs;
}

cv::Mat rendered(const Discs& discs, const cv::Affine3d& pose, const CameraIntrinsics& camera) {
  struct Hit {
    int pixel;
    float depth, weight;
  };
  std::vector<Hit> hits;
  const cv::Affine3f transform(pose);
  const cv::Matx33f turn = transform.rotation();
  for (std::size_t i = 0; i < discs.points.size(); ++i) {
    const cv::Point3f p = transform * discs.points[i], n = turn * discs.normals[i];
    if (!isFinite(n) || !(p.z > 0) || n.dot(p) > -0.05F * static_cast<float>(cv::norm(p))) continue;
    const double reach = camera.fx * discs.radius / p.z;
    const double u = camera.fx * p.x / p.z + camera.cx, v = camera.fy * p.y / p.z + camera.cy;
    for (int y = std::max(0, static_cast<int>(std::ceil(v - reach)));
         y <= std::min(camera.height - 1, static_cast<int>(std::floor(v + reach))); ++y)
      for (int x = std::max(0, static_cast<int>(std::ceil(u - reach)));
           x <= std::min(camera.width - 1, static_cast<int>(std::floor(u + reach))); ++x) {
        const cv::Point3f ray(static_cast<float>(camera.slopeX(x)), static_cast<float>(camera.slopeY(y)), 1);
        const float depth = n.dot(p) / n.dot(ray);
        const cv::Point3f off = ray * depth - p;
        const auto radius = static_cast<float>(discs.radius);
        const float share = off.dot(off) / (radius * radius);
        if (share < 1) hits.push_back({y * camera.width + x, depth, 1 - share});
      }
  }
  std::stable_sort(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) {
    return a.pixel < b.pixel || (a.pixel == b.pixel && a.depth < b.depth);
  });
  cv::Mat depths = cv::Mat::zeros(camera.height, camera.width, CV_32F);
  for (std::size_t begin = 0; begin < hits.size();) {
    std::size_t end = begin;
    double sum = 0, weights = 0;
    const auto thickness = static_cast<float>(2 * discs.radius);
    for (; end < hits.size() && hits[end].pixel == hits[begin].pixel; ++end) {
      if (hits[end].depth > hits[begin].depth + thickness) continue;
      sum += static_cast<double>(hits[end].weight) * hits[end].depth;
      weights += static_cast<double>(hits[end].weight);
    }
    depths.at<float>(hits[begin].pixel / camera.width, hits[begin].pixel % camera.width) =
        static_cast<float>(sum / weights);
    begin = end;
  }
  return depths;
}

cv::Affine3d lookingAt(const cv::Vec3d& place, const cv::Vec3d& forward, double distance) {
  const cv::Vec3d aside = std::abs(forward[2]) < 0.99 ? cv::Vec3d(0, 0, -1) : cv::Vec3d(1, 0, 0);
  const cv::Vec3d right = cv::normalize(aside.cross(forward)), down = forward.cross(right);
  const cv::Matx33d turn(right[0], right[1], right[2], down[0], down[1], down[2], forward[0], forward[1],
                         forward[2]);
  return {turn, cv::Vec3d(0, 0, distance) - turn * place};
}

}  // namespace estancia::experiments
