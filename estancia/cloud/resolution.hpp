// Cloud resolution: point spacing and sensor noise of a point cloud, estimated, and noise added to a cloud.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

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

/// The cloud with independent Gaussian noise of standard deviation `sigma` [m] added to x, y and z of every
/// point. The noise of a point depends on the seed and on its index alone; the last bit of a float may differ
/// between platforms, whose standard libraries differ in logarithm and cosine. NaN stays NaN; colors and
/// normals are unchanged. Throws Error (invalidOption) on a sigma that is negative or not finite.
PointCloud withGaussianNoise(PointCloud cloud, double sigma, std::uint64_t seed);

/// The cloud with the noise of a structured-light depth camera at the origin that looks along z: Gaussian,
/// along the ray, its standard deviation `atOneMeter` z² [m]; and across the ray, `across` z (Nguyen, Izadi,
/// Lovell: Modeling Kinect sensor noise, 3DIMPVT 2012: about 0.0019 m and 0.8 pixels, 0.0014). Else as
/// withGaussianNoise().
PointCloud withDepthNoise(PointCloud cloud, double atOneMeter, double across, std::uint64_t seed);

}  // namespace estancia
