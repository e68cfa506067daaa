// Sensor noise: a point cloud with independent noise added to its points.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "estancia/core/point_cloud.hpp"

namespace estancia {

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
