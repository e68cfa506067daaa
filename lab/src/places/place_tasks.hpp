// Place tasks experiment: mapping, localization and room classification, model by model.
// docs/measured/conjunction.md shows the table that it makes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "estancia/core/progress.hpp"
#include "estancia/findings/findings.hpp"
#include "runner/experiment.hpp"
#include "runner/grid.hpp"
#include "runner/subjects.hpp"

namespace estancia {

class ConfigFile;

}  // namespace estancia

namespace estancia::experiments {

struct PlaceTasksOptions {
  /// A drive that becomes a map, and another one that is found in it.
  struct Drive {
    std::string name;
    SequenceSource images;
    SequenceSource again;
    /// CSV query,refs (readAdmissibleImages); "" = by rooms.
    std::filesystem::path truth;
    bool optional = false;
    /// Poses are left out: what the words alone are worth.
    bool imagesAlone = false;
  };
  /// Images whose rooms are known: those of the one half name the nearest of the other.
  struct Rooms {
    std::string name;
    SequenceSource images;
    /// CSV with a header, one line an image.
    std::filesystem::path table;
    std::string imageColumn = "image", roomColumn = "room", splitColumn = "split";
    /// Values of the split column.
    std::string train = "train", test = "test";
    /// Only these; none: all.
    std::vector<std::string> rooms;
    bool optional = false;
  };

  /// Names, folders, several joined by +; none: all that are installed.
  std::vector<std::string> models;
  std::vector<Drive> drives;
  std::vector<Rooms> rooms;
};

/// Throws Error `file:line: …` on unknown, missing or wrong keys.
PlaceTasksOptions readPlaceTasks(ConfigFile& config);

/// The columns of its results.csv; a task has some of the measures.
GridColumns placeTasksColumns();

/// Runs the tasks with the default mapper and localizer. Throws Error when a model, or a sequence that is not
/// optional, cannot be opened.
Findings comparePlaceTasks(const PlaceTasksOptions& options, Grid& grid, const ExperimentRun& run,
                           Progress& progress);

}  // namespace estancia::experiments
