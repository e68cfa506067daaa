// Rooms-by-name experiment: rooms of images and areas by the rooms' names alone, without an example.
// docs/measured/words.md reports the results.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "estancia/core/progress.hpp"
#include "estancia/findings/findings.hpp"
#include "runner/drive_grid.hpp"
#include "runner/experiment.hpp"
#include "runner/grid.hpp"
#include "runner/subjects.hpp"

namespace estancia {

class ConfigFile;

}  // namespace estancia

namespace estancia::experiments {

struct RoomsByNameOptions {
  /// Images that are asked about, and the rooms that they may show.
  struct Task {
    std::string name;
    /// Images of these rooms; none: all images.
    std::vector<std::string> only;
    /// The rooms that are listed; none: commonRooms().
    std::vector<std::string> rooms;
  };

  /// Names, folders, several joined by +; none: all that are installed.
  std::vector<std::string> models;
  /// Names of groupings().
  std::string groups = "blocks";
  /// Images in a block.
  int block = 10;
  std::vector<Task> tasks;
  std::vector<NamedDrive> drives;
};

/// Throws Error `file:line: …` on unknown, missing or wrong keys.
RoomsByNameOptions readRoomsByName(ConfigFile& config);

/// model,data,task,of,images,chance,accuracy, …; `of`: "(all)", a true room, or "area 1: truth, answer".
GridColumns roomsByNameColumns();

/// Names the images of every task of all data one by one and in groups. Throws Error when a model, or data
/// that is not optional, cannot be opened; unknownName where WordNet does not know a room; missingDependency
/// without WordNet.
Findings nameRooms(const RoomsByNameOptions& options, Grid& grid, const ExperimentRun& run,
                   Progress& progress);

Findings roomsByNameFindings(const DriveResults& results);

}  // namespace estancia::experiments
