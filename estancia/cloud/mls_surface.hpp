// The surface behind noisy points: where they lie on average, and which way it faces there.
#pragma once

#include <cstdint>
#include <opencv2/core/types.hpp>
#include <vector>

#include "estancia/core/point_cloud.hpp"

namespace estancia {

/// Lengths [m]. Averages reach further along the normal, where noise spreads the points, than across it,
/// where they would flatten the surface.
struct MlsOptions {
  double leaf = 0;     ///< edge of the voxels whose means, and how many points each has, stand for the points
  double radius = 0;   ///< of the ball that a normal is fitted to
  double width = 0;    ///< radius of the cylinder around the normal that heights are averaged over
  double depth = 0;    ///< half the length of that cylinder
  double spacing = 0;  ///< edge of the voxels of the result, of which each keeps one point; 0: keep all
  cv::Point3f viewpoint{0, 0, 0};  ///< that normals look towards
  bool away = false;               ///< they look away from it instead: from the middle of an object
  double perPoint = 1;             ///< what a point weighs, when several draws of one cloud lie together
  int threads = 0;                 ///< 0: one a usable core
};

/// Moves each of `seeds` (none: the means of the voxels of `leaf`) along the normal onto the mean of `cloud`
/// (moving least squares with planes: Alexa et al., Computing and rendering point set surfaces, 2003), twice,
/// and gives it the normal there. Dropped are seeds with hardly a point around. Normals of `cloud`, where it
/// has some, say which way the surface faces, and keep the two sides of a thin object apart. The same for any
/// number of threads. Throws Error on lengths that are not positive.
PointCloud projectMls(const std::vector<cv::Point3f>& seeds, const PointCloud& cloud,
                      const MlsOptions& options);

}  // namespace estancia
