// Home known objects experiment: things that are cut out of one drive, looked for in the map of another.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "estancia/core/progress.hpp"
#include "estancia/findings/findings.hpp"
#include "runner/experiment.hpp"
#include "runner/grid.hpp"

namespace estancia {

class ConfigFile;

}  // namespace estancia

namespace estancia::experiments {

struct HomeKnownObjectsOptions {
  /// Folders of drives with true poses and instance masks (home_truth.hpp); each is mapped, with the models
  /// of each other one.
  std::vector<std::string> drives;
  /// Models of small things (a diagonal of at most 0.75 m), and as many of others.
  std::size_t models = 20;
  /// Pixels with depth that four frames of both drives show of a small thing; 2.5 times as many of others.
  std::size_t minPixels = 120;
  /// Maps and cuts out of every such frame.
  std::size_t every = 1;
};

/// Throws Error `file:line: …` on unknown, missing or wrong keys.
HomeKnownObjectsOptions readHomeKnownObjects(ConfigFile& config);

/// map,models_of,size,models,right,wrong,named,seconds
GridColumns homeKnownObjectsColumns();

/// A model is right where an object with its name is the thing that it was cut out of, or one of the same
/// kind: the middles of their boxes are nearer than a quarter of the thing's diagonal, or the pose is within
/// 0.15 of it. Throws Error when a drive has no masks, no poses or cannot be read.
Findings findHomeKnownObjects(const HomeKnownObjectsOptions& options, Grid& grid, const ExperimentRun& run,
                              Progress& progress);

}  // namespace estancia::experiments
