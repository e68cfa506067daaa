// Plane fit: total least squares through points, and whether points are planar.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <opencv2/core/matx.hpp>
#include <opencv2/core/types.hpp>
#include <optional>
#include <span>
#include <vector>

namespace estancia {

struct PlaneFit {
  cv::Vec3d center, normal;  ///< the normal is of unit length
  double distance(const cv::Point3f& p) const { return (cv::Vec3d(p.x, p.y, p.z) - center).dot(normal); }
};

/// The plane (total least squares) of finite points; none when they are fewer than three or `minPoints`, or
/// collinear.
std::optional<PlaneFit> fitPlane(std::span<const cv::Point3f> points, std::size_t minPoints = 3);

/// Whether 95 % of the points lie within 4 mm of one plane, the noise of depth cameras at 1 m; at `distance`
/// [m] the tolerance grows with its square. False for fewer than 50 points.
bool isPlanar(std::vector<cv::Point3f> points, double distance);

}  // namespace estancia
