// Trajectory files: read TUM (`t x y z qx qy qz qw` per line) and KITTI (3×4 matrix per line), write TUM.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "estancia/core/frame.hpp"
#include "estancia/core/pose.hpp"

namespace estancia {

/// One line of a trajectory file.
struct TrajectoryPoint {
  /// [s]; absent in KITTI files and where not finite.
  std::optional<double> timestamp;
  /// With a unit quaternion; absent where the line holds NaN or no rotation.
  std::optional<Pose> pose;
};

struct Trajectory {
  /// In the order of the file.
  std::vector<TrajectoryPoint> points;
  /// Sentences about unusable poses and unordered or repeated time stamps.
  std::vector<std::string> warnings;
};

/// Reads a TUM (8 numbers per line) or KITTI (12 numbers) trajectory; the first line decides which. `#`
/// starts a comment. Throws Error with file and line when a line is neither, and when there is no pose.
Trajectory readTrajectory(const std::filesystem::path& file);

/// Writes TUM lines, every number with all digits: reading them gives the same trajectory. Throws Error when
/// a point lacks its time stamp or pose, and when the file cannot be written.
void writeTrajectory(const std::vector<TrajectoryPoint>& points, const std::filesystem::path& file);

/// Writes the poses of these frames as TUM lines that SequenceOptions::poses matches to the same frames. When
/// all frames have time stamps, frames without a pose are left out. Otherwise poses are matched by order:
/// frames are numbered from 0, and those without a pose are written as `nan`. Throws Error when no frame has
/// a pose and when the file cannot be written.
void writePoses(const std::vector<Frame>& frames, const std::filesystem::path& file);

}  // namespace estancia
