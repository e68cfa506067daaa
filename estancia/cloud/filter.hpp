// Point cloud filters: fewer points by a voxel grid, or a denoised surface by Growing Neural Gas.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include "estancia/cloud/growing_neural_gas.hpp"
#include "estancia/core/options.hpp"
#include "estancia/core/point_cloud.hpp"
#include "estancia/core/progress.hpp"

namespace estancia {

struct FilterOptions {
  /// One of filterMethods().
  std::string method = "none";
  /// Points of the result: neurons, or occupied voxels as near to it as possible.
  std::size_t points = 20000;
  /// Edge of a voxel [m]; 0: the one that leaves `points`.
  double leaf = 0;
  /// Its number of neurons is `points`.
  GngOptions gng;
};
OptionGroup declare(FilterOptions& options);

/// The filters by name: none, voxel, gng.
Choices filterMethods();

/// The result of a filter, and what it computed on the way.
struct FilteredCloud {
  PointCloud cloud;
  /// Edge of the voxels [m]; 0 without voxels.
  double leaf = 0;
  /// The graph over the points, which are its neurons, and how it grew; its own cloud is empty.
  NeuralGas gas;
};

/// The filtered cloud. All methods but none drop points that are not finite. A cloud that has at most
/// `points` others is not thinned out: voxel keeps them unless a leaf is given, gng makes each distinct point
/// a neuron. Neurons have the mean color of the points nearest to them, and no normals. Throws Error
/// (unknownName, invalidOption, invalidInput) on an unknown method, on options out of range, and when voxel
/// or gng get a cloud without a finite point; Interrupted.
FilteredCloud filterWithDetails(const PointCloud& cloud, const FilterOptions& options,
                                Progress& progress = Progress::none());

/// Returns only the filtered cloud.
PointCloud filterCloud(const PointCloud& cloud, const FilterOptions& options,
                       Progress& progress = Progress::none());

}  // namespace estancia
