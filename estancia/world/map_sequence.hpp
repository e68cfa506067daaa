// Sequence mapping: a recorded drive becomes a map file with places, zones, areas and objects, in one call.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "estancia/core/progress.hpp"
#include "estancia/label/label_stream.hpp"

namespace estancia {

class Labeler;
struct MapBudget;
struct MapperOptions;
class OptionGroup;
class Sequence;
struct WorldOptions;

/// The options of areas and objects, by name: `declare(options).set("view-shift", "0.1")`.
OptionGroup declare(WorldOptions& options);

struct MapSequenceOptions {
  /// Treatment of an existing map file.
  enum class Existing { refuse, replace, resume };
  Existing existing = Existing::refuse;
  /// Change the defaults for a new map; a map that is resumed keeps what it was made with.
  std::function<void(MapperOptions&)> changeMapper = {};
  std::function<void(WorldOptions&)> changeWorld = {};
  /// Changes the budget that the map keeps; unchanged members stay as they are.
  std::function<void(MapBudget&)> changeBudget = {};
  LabelStreamOptions stream = {};
  /// DriveStart::posesAreInMap.
  bool posesAreInMap = false;
};

/// Report of mapSequence().
struct MappedSequence {
  /// Frames in the map; frames added by this call.
  std::size_t frames = 0, newFrames = 0;
  /// Sentences about frames that were left out since they, or their depth, cannot be read, and about options
  /// of a resumed map that have gone.
  std::vector<std::string> problems;
};

/// Labels the frames of `sequence` and maps them into the file `map`, with all that it allows: areas and
/// objects need depth and a camera; poses are tracked where there are none. Rooms are named by their names
/// alone where WordNet is installed. What an interrupted run has mapped is kept, and can be resumed. Throws
/// Error: fileExists, as MappingSession and WorldMapper do, invalidInput for a labeler that discovers its
/// words (record() gives them first), fileUnreadable when no frame can be used; Interrupted.
MappedSequence mapSequence(const Sequence& sequence, Labeler& labeler, const std::filesystem::path& map,
                           const MapSequenceOptions& options = {}, Progress& progress = Progress::none());

}  // namespace estancia
