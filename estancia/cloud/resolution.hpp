// How far apart a cloud's points are, and how noisy.
#pragma once

#include "estancia/cloud/neighbors.hpp"
#include "estancia/core/point_cloud.hpp"

namespace estancia {

/// The median distance from a point to its nearest neighbor at another place [m], over some 2,000 points
/// spread over the cloud; 0 when there is no other place, or each is taken by more than a hundred points.
double resolutionOf(const Neighbors& points);
double resolutionOf(const PointCloud& cloud);

/// How far apart the points would lie on a grid over the surface that they show [m]: from how many a ball has
/// that is wide beside the noise, so noise hardly matters. The middle of 40 places; 0 when there is no other
/// place than one.
double spacingOf(const Neighbors& points);

/// The standard deviation of the sensor's noise across the surface [m]: what is left of the points beside
/// smooth patches (quadrics) of the surface, some 200 of them. The patches are as large as the noise asks
/// for, so neither units nor density matter. 0 when no patch has points enough.
double estimateNoise(const Neighbors& points, int threads = 0);
double estimateNoise(const PointCloud& cloud, int threads = 0);

}  // namespace estancia
