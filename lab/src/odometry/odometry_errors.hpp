// Odometry experiment: camera trajectories beside the true ones, with noise and with fewer frames.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "estancia/core/progress.hpp"
#include "estancia/findings/findings.hpp"
#include "odometry/altered_drive.hpp"
#include "runner/drive_grid.hpp"
#include "runner/experiment.hpp"
#include "runner/grid.hpp"
#include "runner/subjects.hpp"

namespace estancia {

class ConfigFile;

}  // namespace estancia

namespace estancia::experiments {

struct OdometryErrorsOptions {
  struct Variant {
    std::string name;
    DriveAlteration alteration;
  };
  /// Their words propose loops. Names, folders, several joined by +; none: all that are installed.
  std::vector<std::string> models;
  /// Images with depth, a camera and true poses.
  std::vector<NamedDrive> drives;
  /// None: the drives as they are.
  std::vector<Variant> variants;
  /// Seed of the noise.
  std::uint64_t seed = 1;
};

/// Throws Error `file:line: …` on unknown, missing or wrong keys.
OdometryErrorsOptions readOdometryErrors(ConfigFile& config);

/// model,drive,variant,frames,placed,bridged,keyframes,loops,path,rmse,median,max,online_rmse,corrections,…
GridColumns odometryErrorsColumns();

/// Tracks with the defaults of the odometry. Throws Error when a model, or a drive that is not optional,
/// cannot be opened, a drive has no true poses (insufficientData), and as trackRgbd() does.
Findings compareOdometry(const OdometryErrorsOptions& options, Grid& grid, const ExperimentRun& run,
                         Progress& progress);

Findings odometryFindings(const DriveResults& results);

}  // namespace estancia::experiments
