// Home worlds: whole maps of drives through a home, areas, trajectory and objects, against the truth.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "runner/drive_grid.hpp"

namespace estancia::experiments {

struct HomeWorldsOptions {
  std::vector<std::string> models;
  std::vector<NamedDrive> drives;
  /// Names of ways to get poses; none: all.
  std::vector<std::string> poses;
  /// What the things are; see readThingClasses().
  std::filesystem::path things;
};

/// Throws Error `file:line: …` on unknown, missing or wrong keys.
HomeWorldsOptions readHomeWorlds(ConfigFile& config);

GridColumns homeWorldsColumns();

/// Maps each drive with the default options of `estancia map`, and measures the maps by evaluateWorld().
/// Throws Error as studyDrives(), evaluateWorld() and readThingClasses() do.
Findings mapHomeWorlds(const HomeWorldsOptions& options, Grid& grid, const ExperimentRun& run,
                       Progress& progress);

}  // namespace estancia::experiments
