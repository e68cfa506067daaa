// Rooms by name: a finished map names its rooms without any example.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "estancia/world_file/world_map.hpp"

namespace estancia {

/// Throws Error unless rooms can be predicted by these names, before the long work begins: missingDependency
/// without WordNet, unknownName, insufficientData.
void requireRoomNames(const std::vector<std::string>& rooms);

/// Predicts the rooms of the frames of a map file by their names alone (predictRoomsByNames()), of
/// `maxFrames` at most, and stores them in place of earlier predictions. Without `rooms`, commonRooms() are
/// tried. Throws Error as readMap() and requireRoomNames() do.
void nameRoomsByNames(const std::filesystem::path& map, const std::vector<std::string>& rooms = {},
                      std::size_t maxFrames = maxFramesOfAnswers);

/// Updates the rooms after a map was made or continued: a trained classifier's predictions stay, and rooms
/// that were listed once are listed again. Returns whether the map has predictions by names now; it has none
/// without WordNet, where WordNet lacks the common rooms, and without frames.
bool renewRoomsByNames(const std::filesystem::path& map);

/// Updates the rooms of a growing map repeatedly.
class GrowingRooms {
 public:
  /// Names the areas in `world` alone, read from `map`, by a thousand of its frames at most, however long the
  /// drive is. Does nothing where renewRoomsByNames() would not. Throws Error as readMap() does.
  void name(const std::filesystem::path& map, WorldMap& world);

 private:
  struct Known;
  std::shared_ptr<Known> known_;
};

}  // namespace estancia
