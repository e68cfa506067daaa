// Point clouds in PLY files, the Stanford Triangle Format.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "estancia/core/point_cloud.hpp"

namespace estancia {

/// Pairs of points of a cloud, by their indices.
using CloudEdges = std::vector<std::array<std::uint32_t, 2>>;

/// Reads the vertices of a PLY file of version 1.0 (ascii, binary_little_endian, binary_big_endian; Turk
/// 1994): x, y, z (any type of number; NaN is kept), nx, ny, nz as normals, and red, green, blue as colors
/// (integers of one byte; others are brought to one: two bytes 65535, floats 1 at most). Other properties,
/// and other elements such as faces and edges, are checked and passed over. Throws Error when the file cannot
/// be read, is cut short, or contradicts itself.
PointCloud readPly(const std::filesystem::path& file);

/// Writes the cloud as vertices, binary_little_endian, or as text, out of which readPly makes the same
/// numbers; and `edges`, unless there are none, as an element `edge` of vertex1 and vertex2. PLY knows
/// neither holes nor organized clouds: points that are not finite are left out. Throws Error when none is
/// left, on an edge to a point that is not there, on too few colors or normals, and when the file cannot be
/// written (writeWhole).
void writePly(const std::filesystem::path& file, const PointCloud& cloud, const CloudEdges& edges = {},
              bool ascii = false);

}  // namespace estancia
