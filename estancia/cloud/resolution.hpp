// Cloud resolution: point spacing and sensor noise of a point cloud, estimated from its points.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estancia/core/point_cloud.hpp"

namespace estancia {

class Neighbors;

/// The median distance from a point to its nearest neighbor at another place [m], over about 2,000 points
/// spread over the cloud; 0 when there is no other place, or each place has more than a hundred points.
double resolutionOf(const Neighbors& points);
double resolutionOf(const PointCloud& cloud);

/// The spacing of the points as if they lay on a grid over the surface [m]: from the number of points in a
/// ball that is wide compared with the noise, so noise hardly matters. The median of 40 places; 0 when all
/// points coincide.
double spacingOf(const Neighbors& points);

/// The standard deviation of the sensor's noise across the surface [m]: the residual of quadrics fitted to
/// about 200 patches of the surface. The size of the patches follows the noise, so neither units nor density
/// matter. 0 when no patch has enough points.
double estimateNoise(const Neighbors& points, int threads = 0);
double estimateNoise(const PointCloud& cloud, int threads = 0);

}  // namespace estancia
