// Word position experiment: does the word map of a drive have a thing's word where the thing stands?
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <utility>
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

struct WordPositionsOptions {
  /// Names, folders, several joined by +; none: all that are installed.
  std::vector<std::string> models;
  /// RGB-D with the truth of a home: home.json, instances.csv, visible.csv.
  std::vector<NamedDrive> drives;
  /// The words for things of a category of instances.csv; each is looked up as findLabels() does.
  std::vector<std::pair<std::string, std::vector<std::string>>> words;
  /// How far from a thing its word may be [m].
  double reach = 0.75;
  /// Maximum number of categories, by the pixels that a drive sees of them; 0: all.
  std::size_t categories = 20;
  /// Pixels of an instance in an image that shows it well enough to be named.
  std::size_t minPixels = 150;
};

/// Throws Error `file:line: …` on unknown, missing or wrong keys.
WordPositionsOptions readWordPositions(ConfigFile& config);

/// model,drive,variant,category,distance,found,categories,share
GridColumns wordPositionsColumns();

/// Makes the word map (WordMap) of each drive with depth, without, and of the true categories of the things
/// that each image shows; a category is found when the strongest cell of one of its words is near one of its
/// instances. Throws Error when a model, or a drive that is not optional, cannot be opened, or lacks depth,
/// poses, a camera, or the truth.
Findings compareWordPositions(const WordPositionsOptions& options, Grid& grid, const ExperimentRun& run,
                              Progress& progress);

Findings wordPositionsFindings(const DriveResults& results);

}  // namespace estancia::experiments
