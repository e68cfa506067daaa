// Which points of a surface are worth describing (thesis 2.4.2).
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "estancia/recognition/surface.hpp"

namespace estancia {

/// The detectors by name, each with one line of explanation: uniform, harris3d, iss.
std::vector<std::pair<std::string, std::string>> keypointMethods();

/// Keypoints of a surface as ascending indices of its points. `spacing` [m] is
///   uniform   the edge of the cells of which each gives its point nearest to the mean of all that lie in it
///   harris3d  the radius within which normals vary (Sipiran and Bustos 2011 by PCL's covariance of normals,
///             det − 0.04 tr²) and a keypoint is the strongest
///   iss       the radius of the scatter matrix (Zhong 2009; both ratios of its eigenvalues below 0.975); 2/3
///             of it, the smallest eigenvalue is the largest around
/// Throws Error on an unknown method, naming the known ones, and on a spacing that cannot be.
std::vector<std::uint32_t> findKeypoints(const Surface& surface, const std::string& method, double spacing,
                                         int threads = 1);

}  // namespace estancia
