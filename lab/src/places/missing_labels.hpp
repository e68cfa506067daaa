// Missing labels experiment: places and rooms by a labeler that returns its best n labels only
// (thesis 3.4.2, 3.7). SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "runner/drive_grid.hpp"

namespace estancia {

class ConfigFile;

}  // namespace estancia

namespace estancia::experiments {

struct MissingLabelsOptions {
  struct Drive {
    NamedDrive itself;
    /// Its places, mapped and found again by these images; or rooms to learn, which these images are asked
    /// for.
    SequenceSource again;
    bool areRooms = false;
  };
  /// Names, folders, several joined by +; none: all that are installed.
  std::vector<std::string> models;
  std::vector<Drive> drives;
  /// How many labels of an image are returned; 0: all.
  std::vector<std::size_t> best{3, 5, 10, 20, 50, 100, 0};
  /// Orders of the places, of which the mean is reported.
  std::size_t orders = 12;
};

/// What stands for a missing label.
enum class Missing {
  /// The library's: missingProbability().
  half,
  /// An equal share of what the others lack to 1, at most the least of them.
  share,
  /// Nothing: the floor of the logarithm.
  floor
};

/// The descriptors with their `best` labels only (0: all), and what stands for the others.
DescriptorMatrix withBest(const DescriptorMatrix& all, std::size_t best, Missing missing);

/// Throws Error `file:line: …` on unknown, missing or wrong keys.
MissingLabelsOptions readMissingLabels(ConfigFile& config);

/// model,drive,variant,missing,v_measure,deviation,nodes,nearest,accuracy
GridColumns missingLabelsColumns();

/// Throws Error when a model, or a drive that is not optional, cannot be opened.
Findings compareMissingLabels(const MissingLabelsOptions& options, Grid& grid, const ExperimentRun& run,
                              Progress& progress);

}  // namespace estancia::experiments
