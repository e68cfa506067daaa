// Area names: what areas are called by people, by a room classifier, and by their words.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "estancia/world_file/world_map.hpp"

namespace estancia {

/// Sets predictedRoom, roomProbability and roomName of the areas of a map whose places a room classifier has
/// named: the predictions of the frames that were taken in an area, pooled (poolRooms()). A room is an area's
/// name where it is sure (RoomPredictions::sureProbability()). Rooms that are known to occur are also
/// assigned one to one to the areas that are not, the most probable pair first. Several areas of one room are
/// numbered in their order: "bedroom 1", "bedroom 2". One keeps its number when a person names another;
/// people's names are left to the areas that they gave them to.
void nameAreasByRooms(WorldMap& world);
/// Names areas by predictions of some of their frames: `areaOfRow[i]` is the area that row i was taken in, -1
/// for none. Names by other predictions are forgotten.
void nameAreasByRooms(WorldMap& world, const RoomPredictions& predictions, std::span<const int> areaOfRow);

/// The areas that have a name, by the first of these that any has: the name that people gave, the room name,
/// the predicted room, of which there may be several.
std::vector<int> areasNamed(const WorldMap& world, const std::string& text);

/// The areas whose name, given or of a room, holds the words as whole words: "music" in "music room".
std::vector<int> areasNamedPartly(const WorldMap& world, const std::string& text);

/// Like areasNamed(); where there are none, those with these telling words.
std::vector<int> areasCalled(const WorldMap& world, const std::string& text);

}  // namespace estancia
