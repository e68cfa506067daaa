// Clouds with fewer, better points: the filters by name.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "estancia/cloud/growing_neural_gas.hpp"
#include "estancia/core/point_cloud.hpp"
#include "estancia/core/progress.hpp"

namespace estancia {

struct FilterOptions {
  std::string method = "none";  ///< one of filterMethods()
  std::size_t points = 20000;   ///< that are to be left: neurons, or occupied voxels as near as can be
  double leaf = 0;              ///< edge of a voxel [m]; 0: the one that leaves `points`
  GngOptions gng;               ///< its number of neurons is `points`
};

/// The filters, each with one line of explanation: none, voxel, gng.
std::vector<std::pair<std::string, std::string>> filterMethods();

/// The filtered cloud; points that are not finite are left out by every method but none. A cloud that has no
/// more than `points` points comes back as it is, whichever the method.
/// Throws Error on an unknown method (naming the known ones) and on options that make no sense; Interrupted.
PointCloud filterCloud(const PointCloud& cloud, const FilterOptions& options, Progress& progress);

}  // namespace estancia
