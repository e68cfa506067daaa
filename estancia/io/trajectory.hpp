// Trajectories as text files: TUM (`t x y z qx qy qz qw` a line) and KITTI (12 numbers of a 3×4 matrix a
// line).
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "estancia/core/frame.hpp"
#include "estancia/core/pose.hpp"

namespace estancia {

/// One line of a trajectory file.
struct TrajectoryPoint {
  std::optional<double> timestamp;  ///< seconds; absent in KITTI files and where not finite
  std::optional<Pose> pose;         ///< unit quaternion; absent where the line holds NaN or no rotation
};

struct Trajectory {
  std::vector<TrajectoryPoint> points;  ///< in the order of the file
  std::vector<std::string> warnings;    ///< sentences: unusable poses, unordered or doubled time stamps
};

/// Reads a TUM (8 numbers a line) or KITTI (12 numbers) trajectory, told apart by their first line. `#`
/// starts a comment. Throws Error naming file and line when a line is neither, and when there is no pose at
/// all.
Trajectory readTrajectory(const std::filesystem::path& file);

/// Writes the points in TUM form, every number with all its digits: reading it back gives the same
/// trajectory. Throws Error when a point has no time stamp or pose, or the file cannot be written.
void writeTrajectory(const std::filesystem::path& file, const std::vector<TrajectoryPoint>& points);

/// Writes the poses of these frames in TUM form such that SequenceOptions::poses finds them again. Frames
/// without a pose are left out where all frames have time stamps; otherwise poses go by order: frames are
/// numbered from 0 instead, and those without a pose are kept as `nan`. Throws Error when no frame has a pose
/// or the file cannot be written.
void writePoses(const std::filesystem::path& file, const std::vector<Frame>& frames);

/// The pose of a rigid transform camera → map, row-major 3×4. Nothing when it is not finite or its left part
/// is no rotation (columns off by more than 1 % from unit length or right angles, or mirrored).
std::optional<Pose> poseOfMatrix(const std::array<double, 12>& matrix);

}  // namespace estancia
