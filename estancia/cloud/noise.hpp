// Clouds as a worse sensor would have seen them.
#pragma once

#include <cstdint>

#include "estancia/core/point_cloud.hpp"

namespace estancia {

/// The cloud with independent Gaussian noise of standard deviation `sigma` [m] added to x, y and z of every
/// point. A point's noise depends on the seed and on its index alone; standard libraries differ in their
/// logarithms' and cosines' last bits, so platforms could in a float's. NaN stays NaN; colors and normals
/// stay as they are. Throws Error on a sigma that is negative or not finite.
PointCloud withGaussianNoise(PointCloud cloud, double sigma, std::uint64_t seed);

}  // namespace estancia
