// Drive store: the tables of drives in a map file. Private; see TopologicalMap::drives.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "estancia/map_file/store.hpp"

namespace estancia {

/// Makes the tables where they are missing.
extern const char* const schemaOfDrives;

/// Writes in the store's transaction; the store must outlive it.
class DriveStore {
 public:
  explicit DriveStore(MapStore& store) : store_(store) {}

  /// Inserts, or replaces the one that begins at the same frame.
  void put(const Drive& drive);
  /// The pose of a frame as it was given, in its drive's own frame.
  void putGivenPose(std::size_t frame, const Pose& pose);

  /// In order of frames; none in maps of older programs.
  std::vector<Drive> drives() const;
  /// Whether a frame of the map has a pose.
  bool hasPoses() const;
  /// Nothing where none was given, or it was in the map's frame.
  std::optional<Pose> givenPose(std::size_t frame) const;

 private:
  MapStore& store_;
};

}  // namespace estancia
