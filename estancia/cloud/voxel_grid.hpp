// Voxel grid: a cloud with one point for each occupied voxel.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "estancia/core/point_cloud.hpp"

namespace estancia {

/// The mean of the points in each voxel, and of their colors and normals. The edge of a voxel is `leaf` [m],
/// and a corner of one is the origin. Voxels are in the order of their first points; points that are not
/// finite are left out. Voxels are hashed, so any leaf works for any extent (PCL's VoxelGrid has 32-bit
/// indices, and returns the cloud unchanged when they overflow). `counts`, when given, gets the number of
/// points in each voxel. Throws Error (invalidOption) when the leaf is not above 0.
PointCloud voxelGrid(const PointCloud& cloud, double leaf, std::vector<std::uint32_t>* counts = nullptr);

/// For each voxel: index of the point nearest to the mean of its points; ascending. The grid starts at the
/// low corner of the bounding box.
std::vector<std::uint32_t> onePerVoxel(const std::vector<cv::Point3f>& points, double leaf);

struct Leaf {
  double size = 0;         ///< edge of a voxel [m]
  std::size_t points = 0;  ///< points of the result
};

/// The leaf whose result has as nearly `points` points as possible; a larger leaf mostly leaves fewer. Throws
/// Error (invalidInput, invalidOption) when no point is finite or `points` is 0.
Leaf findLeaf(const PointCloud& cloud, std::size_t points);

}  // namespace estancia
