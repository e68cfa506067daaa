// Room answers: predictions from the names of rooms alone for images whose rooms are known, one by one and
// pooled.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "estancia/core/frame.hpp"
#include "estancia/core/room_predictions.hpp"
#include "runner/grid.hpp"

namespace estancia::experiments {

/// Images that are named together.
struct ImageGroups {
  /// Group of each image, 0 …; rooms.size(): none.
  std::vector<std::size_t> groupOf;
  /// The true room of each group; "": unknown.
  std::vector<std::string> rooms;
};

/// Blocks of `size` images that follow each other among those of one room; what is left of a room belongs to
/// none. Rooms in order of their first image.
ImageGroups blocksOfRooms(const std::vector<Frame>& frames, std::size_t size);

/// Areas, whose rooms are those that most of their images were taken in. `areaOf`: of each image, 0 …; < 0:
/// none.
ImageGroups groupsOfAreas(const std::vector<Frame>& frames, const std::vector<int>& areaOf);

/// What one group was taken for.
struct GroupAnswer {
  std::size_t images = 0;
  /// Both "" where unknown.
  std::string truth, answer;
  double probability = 0;
  /// Whether that is enough for a name.
  bool isSure = false;
};

/// Names blocks like places and zones: poolRooms(), sure above RoomPredictions::sureProbability().
std::vector<GroupAnswer> nameBlocks(const RoomPredictions& predictions, const ImageGroups& groups);

/// Names groups like the areas of a map: nameAreasByRooms().
std::vector<GroupAnswer> nameAreaGroups(const RoomPredictions& predictions, const ImageGroups& groups);

/// The measures of roomsByNameColumns() at "(all)" and at each true room. Images and groups of unknown rooms
/// do not count; an image without a prediction is wrong. Names are equal as sameWords() has it. The interval
/// of images is shareRight(), with runs of images of one room; that of groups takes each for independent.
/// Throws Error (insufficientData) when no image has a known room.
CellResults measureRoomAnswers(const RoomPredictions& predictions, const std::vector<Frame>& frames,
                               const std::vector<GroupAnswer>& groups);

}  // namespace estancia::experiments
