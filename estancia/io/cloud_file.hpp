// Point clouds in files, whichever the format.
#pragma once

#include <filesystem>

#include "estancia/core/point_cloud.hpp"
#include "estancia/io/ply.hpp"

namespace estancia {

/// What a depth image does not say itself. Clouds in other files need none of it.
struct CloudFileOptions {
  double depthScale = 0;  ///< what a meter is in its numbers; 0: what is usual for its kind (io::readDepth)
  /// The camera (io::readIntrinsics); "" takes the file of a usual name in the image's folder or the one
  /// above.
  std::filesystem::path intrinsics;
  /// A color image of the same view, brought to the depth's size; "": none.
  std::filesystem::path colors;
};

/// Reads a cloud by the ending of its name: .pcd (readPcd), .ply (readPly), or a depth image (.png, .tif,
/// .tiff, .exr, .pfm, .pgm), which becomes an organized cloud in the camera's optical frame. Throws Error
/// when the file cannot be read, is none of these, or is a depth image of an unknown camera.
PointCloud readCloud(const std::filesystem::path& file, const CloudFileOptions& options = {});

/// Whether a file begins as PCD or PLY files do, whatever its name.
bool isCloudFile(const std::filesystem::path& file);

/// Throws Error, naming the endings that are known, unless writeCloud can write such a file.
void requireCloudFile(const std::filesystem::path& file, bool edges = false);

/// Writes a cloud by the ending of the file's name: .pcd (writePcd) or .ply (writePly), binary. Edges go into
/// .ply only. Throws Error on other endings and when the file cannot be written.
void writeCloud(const std::filesystem::path& file, const PointCloud& cloud, const CloudEdges& edges = {});

}  // namespace estancia
