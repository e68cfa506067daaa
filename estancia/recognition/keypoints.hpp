// Keypoint detection on surfaces: uniform sampling, Harris 3D, ISS (thesis 2.4.2).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "estancia/core/options.hpp"
#include "estancia/recognition/surface.hpp"

namespace estancia {

/// The detectors by name: uniform, harris3d, iss.
Choices keypointMethods();

/// Keypoints of a surface as ascending indices of its points. `spacing` [m] is
///   uniform   the edge of the voxels, each of which gives its point nearest to the mean of its points
///   harris3d  the radius of the covariance of normals (Sipiran and Bustos 2011 as in PCL, det − 0.04 tr²)
///   and of
///             non-maximum suppression
///   iss       the radius of the scatter matrix (Zhong 2009; both ratios of its eigenvalues below 0.975);
///             non-maximum suppression of the smallest eigenvalue within 2/3 of it
/// Throws Error (unknownName, invalidOption) on an unknown method and on a spacing that is not positive, or
/// far below the resolution.
std::vector<std::uint32_t> findKeypoints(const Surface& surface, const std::string& method, double spacing,
                                         int threads = 1);

}  // namespace estancia
