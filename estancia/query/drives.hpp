// Drives of a map: what each one saw of places that were known before, and where it was recognized first.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "estancia/map_file/map.hpp"

namespace estancia {

struct DriveSummary {
  Drive drive;
  /// The number of its first frame.
  std::size_t first = 0;
  /// How many were mapped, and how many of them the file keeps (MapBudget).
  std::size_t frames = 0, kept = 0;
  /// First and last time stamp [s], where the frames have any.
  std::optional<double> begins, ends;
  /// Places that it was in, and those of them that it was the first to be in.
  std::size_t places = 0, newPlaces = 0;
  /// Frames with a pose in the map.
  std::size_t posed = 0;
  /// The first frame that was recognized in a place of an earlier drive, counted from the drive's first, and
  /// that place; nothing where none was, and in the first drive.
  struct Recognized {
    std::size_t after = 0;
    int node = 0;
  };
  std::optional<Recognized> recognized;
};

/// "drive 1 (evening)".
std::string describeDrive(const TopologicalMap& map, std::size_t drive);

/// In order of frames.
std::vector<DriveSummary> summarizeDrives(const TopologicalMap& map);

}  // namespace estancia
