// Which way surfaces face.
#pragma once

#include <cstddef>
#include <opencv2/core/types.hpp>
#include <span>
#include <vector>

#include "estancia/cloud/neighbors.hpp"

namespace estancia {

struct NormalOptions {
  double radius = 0;               ///< [m] of the points that a plane is fitted to; 0: `neighbors` says which
  std::size_t neighbors = 0;       ///< so many nearest points, and those that are no further than the last
  cv::Point3f viewpoint{0, 0, 0};  ///< that normals look towards: where the sensor was
  int threads = 0;                 ///< 0: one a usable core
};

/// The normal at each of `places` of the surface that `points` show: the direction in which the points around
/// vary least (Hoppe et al., SIGGRAPH 1992; Rusu 2010). Unit vectors towards the viewpoint; NaN where a place
/// is not finite, or has fewer than three points around it, or these lie on a line. The same for any number
/// of threads. Throws Error unless either a radius or a number of neighbors is given.
std::vector<cv::Point3f> estimateNormals(std::span<const cv::Point3f> places, const Neighbors& points,
                                         const NormalOptions& options);

}  // namespace estancia
