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

/// What a filter leaves, and what it had to find out.
struct FilteredCloud {
  PointCloud cloud;
  double leaf = 0;  ///< edge of the voxels [m]; 0 without voxels
  /// The graph over the points, which are its neurons, and how it grew; its own cloud is empty.
  NeuralGas gas;
};

/// The filtered cloud. All methods but none leave out points that are not finite. Of a cloud that has no more
/// than `points` of the others there is nothing to thin out: voxel keeps them unless it has a leaf, gng makes
/// each place a neuron. Neurons have the color of the point nearest to them, and no normals. Throws Error on
/// an unknown method (naming the known ones), on options that make no sense, and when voxel or gng get a
/// cloud without a finite point; Interrupted.
FilteredCloud filterWithDetails(const PointCloud& cloud, const FilterOptions& options, Progress& progress);

/// The same without the details.
PointCloud filterCloud(const PointCloud& cloud, const FilterOptions& options, Progress& progress);

}  // namespace estancia
