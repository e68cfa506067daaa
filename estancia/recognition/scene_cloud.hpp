// Scene cloud: a cloud file, a depth image with its camera, or frames of a drive, as one point cloud.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "estancia/core/frame.hpp"
#include "estancia/core/point_cloud.hpp"
#include "estancia/files/cloud_file.hpp"
#include "estancia/sequences/sequence.hpp"

namespace estancia {

struct SceneCloudOptions {
  /// How a drive is opened; its depthScale and intrinsics hold for a depth image, too.
  SequenceOptions sequence;
  /// The colors of a depth image, the unit of a cloud.
  CloudFileOptions file;
  /// Frames of a drive, by their names or numbers from 0, separated by commas. Empty: the only one.
  std::vector<std::string> frames;
};

/// A cloud in meters.
struct SceneCloud {
  /// With the viewpoint, where the points are of one camera.
  PointCloud cloud;
  /// The frames of the drive that it is of; none of a file.
  std::vector<Frame> frames;
  /// Problems of the drive: Sequence::warnings().
  std::vector<std::string> warnings;
  /// What the points are relative to: "cloud", as in the file; "camera", of the depth image or the only
  /// frame; "map", of the drive's poses, where several frames are joined.
  std::string_view reference = "cloud";
};

/// Reads a .pcd or .ply, a depth image, or what openSequence() opens. Several frames are joined by their
/// poses, and thinned to the spacing of one frame's points, or as far as the frames disagree. Throws Error as
/// readCloud() and openSequence() do; on a drive of several frames of which none is chosen, on an unknown or
/// repeated one, on a unit or colors for a drive (invalidOption, unknownName), without depth, camera, or
/// poses to join by (insufficientData).
SceneCloud readSceneCloud(const std::filesystem::path& path, const SceneCloudOptions& options = {});

}  // namespace estancia
