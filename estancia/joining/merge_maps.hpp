// Merging maps, and undoing a drive: a map is made anew from what others keep of their drives.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "estancia/core/progress.hpp"
#include "estancia/map_file/map.hpp"

namespace estancia {

/// How work is shared by several processes, which all call mergeMaps() for the same maps.
struct ShareWork {
  /// The one that makes the map; the others only help.
  bool leads = true;
  /// Calls work(i) for all i below `pieces`, each once in one of the processes. Gives what they returned,
  /// here if this one leads, else nothing.
  std::function<std::vector<std::string>(std::size_t pieces,
                                         const std::function<std::string(std::size_t)>& work)>
      run = {};
};

/// Report of mergeMaps().
struct MergedMaps {
  std::size_t drives = 0, frames = 0, places = 0;
  /// By the maps' order but for the first: whether a place of the maps before was recognized in it, and
  /// whether its poses are known in the merged map.
  struct Part {
    bool isRecognized = false, isAligned = false;
    /// Whether it had any that the merged map could know.
    bool hasPoses = false;
  };
  std::vector<Part> parts;
  /// Sentences: options of the first map that have gone since it was made; names that people gave to one area
  /// in both maps, of which the first map's is kept.
  std::vector<std::string> conflicts;
};

/// Makes the map `output` of all drives of the maps. Places of two maps that are recognized as one (by words,
/// the order of images, poses and depth) become one; the rest is kept apart. Maps keep their order, but that
/// one without a place in common with those before waits for one that it has one in common with. The first
/// map gives the options, and the first one with poses their frame. People's names, merges, splits and
/// removals are those of all maps, as far as the maps are aligned. A map whose camera was tracked keeps the
/// poses, but cannot be tracked on. All pairs of maps are compared, which `share` spreads over processes; by
/// default all cores work. Throws Error: as readMap() and MappingSession::create() do; invalidInput for less
/// than two maps, or for two that have a drive in common; mismatch for maps of different vocabularies, models
/// or distances; Interrupted. `output` appears when it is whole.
MergedMaps mergeMaps(std::span<const std::filesystem::path> maps, const std::filesystem::path& output,
                     ExistingMap existing = ExistingMap::refuse, Progress& progress = Progress::none(),
                     ShareWork share = {});

/// Takes a drive out of the map, as if it had never been: all others are mapped anew. People's corrections
/// stay. The map is replaced when the new one is whole. Throws Error: as readMap() does, unknownName for a
/// drive that it does not have, insufficientData where it has no other, busy when another process writes it;
/// Interrupted. Returns a sentence for each option of the map that has gone since it was made.
std::vector<std::string> undoDrive(const std::filesystem::path& map, std::size_t drive,
                                   Progress& progress = Progress::none());

}  // namespace estancia
