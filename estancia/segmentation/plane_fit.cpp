// SPDX-License-Identifier: Apache-2.0
#include "estancia/segmentation/plane_fit.hpp"

#include <algorithm>
#include <cmath>

#include "estancia/cloud/covariance.hpp"

namespace estancia {

std::optional<PlaneFit> fitPlane(std::span<const cv::Point3f> points, std::size_t minPoints) {
  if (points.size() < std::max<std::size_t>(minPoints, 3)) return {};
  cv::Vec3d mean;
  for (const cv::Point3f& p : points) mean += cv::Vec3d(p.x, p.y, p.z);
  mean /= static_cast<double>(points.size());
  cv::Matx33d covariance = cv::Matx33d::zeros();
  for (const cv::Point3f& p : points) {
    const cv::Vec3d d = cv::Vec3d(p.x, p.y, p.z) - mean;
    covariance += d * d.t();
  }
  const cv::Vec3d normal = principalAxes(covariance * (1. / static_cast<double>(points.size()))).normal;
  if (std::isnan(normal[0])) return {};
  return PlaneFit{mean, normal};
}

bool isPlanar(std::vector<cv::Point3f> points, double distance) {
  constexpr std::size_t minPoints = 50, maxPoints = 1000;
  constexpr double tolerance = 0.004, minLimit = 0.003, share = 0.95, trimmed = 0.6;  // [m at 1 m]
  if (points.size() < minPoints) return false;
  if (points.size() > maxPoints) {
    for (std::size_t i = 0; i < maxPoints; ++i) points[i] = points[i * points.size() / maxPoints];
    points.resize(maxPoints);
  }
  const double noise = std::max(1., distance * distance);
  std::vector<double> off(points.size()), sorted;
  std::vector<cv::Point3f> kept = points;
  for (int round = 0; round < 5; ++round) {  // trimmed: the other points may be anywhere
    const auto plane = fitPlane(kept);
    if (!plane) return false;
    for (std::size_t i = 0; i < points.size(); ++i) off[i] = std::abs(plane->distance(points[i]));
    sorted = off;
    const auto rank = static_cast<std::ptrdiff_t>(trimmed * static_cast<double>(points.size()));
    std::ranges::nth_element(sorted, sorted.begin() + rank);
    const double near = std::max(minLimit * noise, sorted[static_cast<std::size_t>(rank)]);
    kept.clear();
    for (std::size_t i = 0; i < points.size(); ++i)
      if (off[i] < near) kept.push_back(points[i]);
  }
  const auto on = std::ranges::count_if(off, [&](double d) { return d < tolerance * noise; });
  return static_cast<double>(on) >= share * static_cast<double>(points.size());
}

}  // namespace estancia
