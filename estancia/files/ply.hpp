// PLY: the Stanford polygon file format, for point clouds and meshes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "estancia/files/cloud_file.hpp"

namespace estancia {

/// Reads the vertices of a PLY file of version 1.0 (ascii, binary_little_endian, binary_big_endian; Turk
/// 1994): x, y, z (any type of number; NaN is kept), nx, ny, nz as normals, and red, green, blue as colors
/// (integers of one byte; others are scaled to one: two bytes from 65535, floats from 1). Other properties,
/// and other elements such as faces and edges, are checked and ignored. Throws Error when the file cannot be
/// read, is truncated, or contradicts itself.
PointCloud readPly(const std::filesystem::path& file);

struct PlyMesh {
  /// Corners, by their indices among the vertices.
  using Triangle = std::array<std::uint32_t, 3>;
  PointCloud vertices;
  std::vector<Triangle> triangles;
};

/// readPly() with the faces (the list vertex_indices or vertex_index of each), if there are any; those of
/// more than three corners as fans of triangles. Throws Error, too, when a face names a vertex that is not
/// there.
PlyMesh readPlyMesh(const std::filesystem::path& file);

/// Writes the cloud as vertices, binary_little_endian, or as text that readPly() reads to the same numbers;
/// and `edges`, unless empty, as an element `edge` of vertex1 and vertex2. PLY has neither holes nor
/// organized clouds: points that are not finite are left out. Throws Error when no point is left, on an edge
/// to a missing point, on too few colors or normals, and when the file cannot be written (writeWhole).
void writePly(const PointCloud& cloud, const std::filesystem::path& file, const CloudEdges& edges = {},
              bool ascii = false);

}  // namespace estancia
