// Localization experiment: one drive found in the map of another, by each image alone and by all so far.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
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

struct LocalizationErrorsOptions {
  struct Drive {
    /// The drive that is mapped.
    NamedDrive mapped;
    /// The drive that is found in it.
    SequenceSource again;
    /// CSV query,refs (readAdmissibleImages()); "": by the poses.
    std::filesystem::path truth;
  };
  /// Names, folders, several joined by +; none: all that are installed.
  std::vector<std::string> models;
  /// Frames that an answer waits for, beside 0.
  std::vector<std::size_t> lookaheads{10};
  std::vector<Drive> drives;
};

/// Reads a drive, its `truth`, and the one to find from `[drive.again]`. Throws Error as below.
LocalizationErrorsOptions::Drive readDrivePair(ConfigFile& config, const toml::table& table);

/// Throws Error `file:line: …` on unknown, missing or wrong keys.
LocalizationErrorsOptions readLocalizationErrors(ConfigFile& config);

/// model,drive,answer,frames,judged,recall,room,node_room,median_error
GridColumns localizationErrorsColumns();

/// Maps and localizes with the defaults. Throws Error when a model, or a drive that is not optional, cannot
/// be opened.
Findings compareLocalization(const LocalizationErrorsOptions& options, Grid& grid, const ExperimentRun& run,
                             Progress& progress);

/// The answers stand in the cells, one after the other.
Findings localizationFindings(const DriveResults& results);

}  // namespace estancia::experiments
