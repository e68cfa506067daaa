// Local covariance: principal axes of the points around a place.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <opencv2/core/matx.hpp>
#include <opencv2/core/types.hpp>

#include "estancia/cloud/neighbors.hpp"

namespace estancia {

struct LocalCovariance {
  std::size_t count = 0;
  cv::Vec3d offset;        ///< from the place to the mean of the points [m]
  cv::Matx33d covariance;  ///< covariance of the points [m²], divided by their number
};

/// Covariance of the points at most √squared [m] away. Sums are relative to the place, so that they are as
/// exact far from the origin as near it.
LocalCovariance localCovariance(const Neighbors& points, const cv::Point3f& place, float squared);

/// Eigenvalues of a covariance, smallest first, and the eigenvector of the smallest.
struct PrincipalAxes {
  std::array<double, 3> variances{};
  cv::Vec3d normal;  ///< direction of the smallest variance, unit length; NaN for collinear points
};

/// In closed form (O. K. Smith: Eigenvalues of a symmetric 3 × 3 matrix. CACM 4(4), 1961).
PrincipalAxes principalAxes(const cv::Matx33d& covariance);

}  // namespace estancia
