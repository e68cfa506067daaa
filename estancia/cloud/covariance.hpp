// How points are spread around a place: what normals and noise are made of.
#pragma once

#include <array>
#include <cstddef>
#include <opencv2/core/matx.hpp>
#include <opencv2/core/types.hpp>

#include "estancia/cloud/neighbors.hpp"

namespace estancia {

struct LocalCovariance {
  std::size_t count = 0;
  cv::Vec3d offset;        ///< of the points' mean from the place [m]
  cv::Matx33d covariance;  ///< of the points [m²], divided by their number
};

/// Of the points at most √squared [m] away. Sums are taken from the place on, so that they are as exact far
/// from the origin as near it.
LocalCovariance localCovariance(const Neighbors& points, const cv::Point3f& place, float squared);

/// Directions of a spread and the variances along them, smallest first.
struct PrincipalAxes {
  std::array<double, 3> variances{};
  cv::Vec3d normal;  ///< of the smallest variance, unit length; NaN when the points lie on a line
};

/// In closed form (O. K. Smith: Eigenvalues of a symmetric 3 × 3 matrix. CACM 4(4), 1961).
PrincipalAxes principalAxes(const cv::Matx33d& covariance);

}  // namespace estancia
