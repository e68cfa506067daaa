// Point cloud files: read and write PCD and PLY, and turn depth images into clouds.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "estancia/core/options.hpp"
#include "estancia/core/point_cloud.hpp"

namespace estancia {

/// Pairs of points of a cloud, by their indices.
using CloudEdges = std::vector<std::array<std::uint32_t, 2>>;

/// Data that a file does not contain itself: the camera of a depth image, the unit of other clouds.
struct CloudFileOptions {
  /// Depth units per meter; 0 takes the default of the image type (SequenceOptions::depthScale).
  double depthScale = 0;
  /// A file with the camera intrinsics; "" takes camera-intrinsics.txt, intrinsics.txt or camera.yaml from
  /// the folder of the image or the one above.
  std::filesystem::path intrinsics = {};
  /// A color image of the same view, resized to the size of the depth image; "" gives no colors.
  std::filesystem::path colors = {};
  /// Unit of the coordinates in a .pcd or .ply, one of lengthUnits(): they are read as meters.
  std::string unit = "m";
};
/// All but the unit.
OptionGroup declare(CloudFileOptions& options);
/// m, cm, mm.
Choices lengthUnits();

/// Reads a point cloud by file extension: .pcd, .ply, or a depth image (.png, .tif, .tiff, .exr, .pfm, .pgm),
/// which becomes an organized cloud in the optical frame of its camera. Throws Error when the file cannot be
/// read, is of another type, or is a depth image without intrinsics or with a unit; on an unknown unit.
PointCloud readCloud(const std::filesystem::path& file, const CloudFileOptions& options = {});

/// True when the content starts like PCD or PLY, whatever the file name.
bool isCloudFile(const std::filesystem::path& file);

/// Throws Error unless writeCloud() writes files with this extension, with edges if `edges`.
void requireCloudFile(const std::filesystem::path& file, bool edges = false);

/// Writes a binary .pcd or .ply, by file extension. Only .ply holds edges. Throws Error on other extensions
/// and when the file cannot be written.
void writeCloud(const PointCloud& cloud, const std::filesystem::path& file, const CloudEdges& edges = {});

}  // namespace estancia
