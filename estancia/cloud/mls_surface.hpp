// Moving least squares: noisy points projected onto their mean surface, with normals.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/types.hpp>
#include <vector>

#include "estancia/core/point_cloud.hpp"

namespace estancia {

/// Lengths [m], all but the spacing above 0. Averages reach further along the normal, where noise spreads the
/// points, than across it, where they would flatten the surface.
struct MlsOptions {
  /// Edge of the voxels whose means, weighted by their numbers of points, replace the points.
  double leaf = 0;
  /// Radius of the ball that a normal is fitted to.
  double radius = 0;
  /// Radius of the cylinder around the normal over which heights are averaged.
  double width = 0;
  /// Half the length of that cylinder.
  double depth = 0;
  /// Edge of the voxels of the result, each of which keeps one point; 0: keep all.
  double spacing = 0;
  /// Towards which normals point.
  cv::Point3f viewpoint{0, 0, 0};
  /// Normals point away from it instead: from the center of an object.
  bool away = false;
  /// Weight of a point, when the cloud consists of several draws of one cloud.
  double perPoint = 1;
  /// 0: one a usable core.
  int threads = 0;
};

/// Moves each of `seeds` (none: the means of the voxels of `leaf`) along the normal onto the mean of `cloud`
/// (moving least squares with planes: Alexa et al., Computing and rendering point set surfaces, 2003), twice,
/// and gives it the normal there. Seeds with hardly a point around are dropped. Normals of `cloud`, if any,
/// orient the surface, and keep the two sides of a thin object apart. Colors are those of the nearest voxels.
/// Results do not depend on the number of threads.
PointCloud projectMls(const std::vector<cv::Point3f>& seeds, const PointCloud& cloud,
                      const MlsOptions& options);

}  // namespace estancia
