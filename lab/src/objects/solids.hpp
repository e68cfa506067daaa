// Solids: boxes, upright cylinders and ellipsoids, as rays meet them; for made-up scenes and models.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <opencv2/core/matx.hpp>
#include <opencv2/core/types.hpp>
#include <span>
#include <vector>

namespace estancia::experiments {

/// Stands on `at`, z up [m]; its two sides or diameters and its height; turned about the upright [rad].
struct Solid {
  enum class Shape { box, cylinder, ellipsoid };
  Shape shape = Shape::box;
  cv::Vec3d at = {}, size = {};
  double angle = 0;
};

/// Where a ray meets a solid first.
struct SolidHit {
  /// How many times the ray; not finite: it does not.
  double t = HUGE_VAL;
  /// The surface's normal, outwards; the point in the solid, −1 … 1 of its half sizes.
  cv::Vec3d normal, local;
};

/// Where the ray from outside meets the solid, if that is nearer than `nearest`.
bool cast(const Solid& solid, const cv::Vec3d& from, const cv::Vec3d& ray, SolidHit& nearest);

/// Points on the surface of all together, about `step` [m] apart, as far as one of six parallel views along
/// the axes sees them.
std::vector<cv::Point3f> surfaceOf(std::span<const Solid> solids, double step);

}  // namespace estancia::experiments
