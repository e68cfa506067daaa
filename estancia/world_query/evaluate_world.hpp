// World accuracy: areas, trajectory and objects of a map against the truth about its drive.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "estancia/objects/instance_accuracy.hpp"
#include "estancia/stats/clustering_agreement.hpp"
#include "estancia/stats/trajectory_error.hpp"

namespace estancia {

/// Values that the map or the truth does not contain are absent.
struct WorldAccuracy {
  std::size_t areas = 0;
  /// Areas as clusters of the frames: against the rooms stood in and the rooms seen.
  std::optional<Agreement> areasAndRooms = {}, areasAndRoomsSeen = {};
  /// Trajectory error over frames with an estimated and a true pose.
  std::optional<AbsoluteTrajectoryError> trajectory = {};
  std::optional<InstanceAccuracy> objects = {};
  /// What speaks against the drive being the one that was mapped; others may have the same images' names.
  std::vector<std::string> doubts = {};
};

/// The motion that carries estimated poses onto true ones (pairs of the same frames): the best rigid one of
/// their positions (absoluteTrajectoryError()), or, where these lie on a line or a point, which leave a turn
/// open, the one of positions and directions. Throws Error as absoluteTrajectoryError().
Pose truthFromMap(std::span<const Pose> estimated, std::span<const Pose> truth);

/// Compares a map file with the folder of the drive that it was made of (io::readHomeTruth()). `roomsSeen`:
/// the room that each frame of the map sees, "" where unknown (io::roomsSeen()). The map may be on axes of
/// its own: boxes are compared after truthFromMap(). Throws Error: as readWorld(), as io::readHomeTruth(),
/// and mismatch when the map's frames are not of that drive.
WorldAccuracy evaluateWorld(const std::filesystem::path& map, const std::filesystem::path& drive,
                            std::span<const std::string> roomsSeen, const ThingClasses& classes = {});

}  // namespace estancia
