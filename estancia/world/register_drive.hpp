// Drive registration: brings what a drive has seen to what the map has seen, by depth. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <opencv2/core/affine.hpp>
#include <optional>
#include <span>

#include "estancia/map_file/store.hpp"
#include "estancia/world_file/observation.hpp"
#include "estancia/world_file/world_store.hpp"

namespace estancia {

/// Where an observation was made.
struct ObservationPose {
  std::size_t frame = 0;
  cv::Affine3d pose;
};

/// T_map_drive near `guess`, or nothing where depth does not confirm it. Up to 24 observations of the drive
/// (poses in its own frame) are aligned with the nearest ones of the map (poses in the map) by point-to-plane
/// distances; at least half of them, and five, must then agree on one transform within 0.15 m and 5°.
std::optional<cv::Affine3d> registerDrive(std::span<const ObservationPose> drive,
                                          std::span<const ObservationPose> map,
                                          const std::function<Observation(std::size_t frame)>& observation,
                                          const cv::Affine3d& guess);

/// Registers the last drive of a map file by the observations in the file.
std::optional<cv::Affine3d> registerDrive(MapStore& map, const WorldStore& seen, const Drive& drive,
                                          const cv::Affine3d& guess);

}  // namespace estancia
