// A cloud with one point for each cube of space that it touches.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "estancia/core/point_cloud.hpp"

namespace estancia {

/// The mean of the points in each voxel, and of their colors and normals; the voxels' edge is `leaf` [m],
/// and one of their corners is the origin. They stand in the order of their first points; points that are not
/// finite are left out. Voxels are hashed, so any leaf will do for any extent (PCL's VoxelGrid numbers them
/// with 32 bits, and gives the cloud back as it is when that is too few). `counts`, when given, is told how
/// many points each voxel has. Throws Error when the leaf is not above 0.
PointCloud voxelGrid(const PointCloud& cloud, double leaf, std::vector<std::uint32_t>* counts = nullptr);

/// Of each voxel (one of whose corners is the lowest of the box around the points) the point nearest to the
/// mean of all in it; ascending indices.
std::vector<std::uint32_t> onePerVoxel(const std::vector<cv::Point3f>& points, double leaf);

struct Leaf {
  double size = 0;         ///< edge of a voxel [m]
  std::size_t points = 0;  ///< that it leaves
};

/// The leaf that leaves as near `points` points as can be found: a larger one mostly leaves fewer. Throws
/// Error when no point is finite or none is wanted.
Leaf findLeaf(const PointCloud& cloud, std::size_t points);

}  // namespace estancia
