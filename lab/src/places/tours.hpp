// Tour experiment: do the places of a map hold from two rooms to many, and from one visit to thirty?
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
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

/// What a robot does in each place, whose images look evenly around.
enum class Visit {
  /// Twelve images all around.
  views,
  /// Thirty-six images all around.
  turning,
  /// It stands and looks into six directions, twelve images each, and turns in three images in between.
  standing
};

/// Frame numbers of a made-up tour: `visits` rounds through `places`, in another order each time, no place
/// twice in a row. Place p is the frames [p · around, (p + 1) · around).
std::vector<std::size_t> tourOf(std::vector<std::size_t> places, std::size_t around, std::size_t visits,
                                Visit visit, std::uint64_t seed);

struct ToursOptions {
  struct Drive {
    /// All its places have as many images, evenly around.
    NamedDrive itself;
    /// How many of its places a tour has.
    std::vector<std::size_t> places;
    /// Every other place, from the first or the second one; else all.
    std::size_t firstPlace = 0, placeStep = 1;
  };
  /// Names, folders, several joined by +; none: all that are installed.
  std::vector<std::string> models;
  std::vector<Drive> drives;
  std::vector<std::size_t> visits{1, 3, 10, 30};
  /// Tours of other places in another order, of which the mean is reported.
  std::size_t tours = 6;
};

/// Throws Error `file:line: …` on unknown, missing or wrong keys.
ToursOptions readTours(ConfigFile& config);

/// model,drive,variant,tour,v_measure,nodes
GridColumns toursColumns();

/// Maps each tour with the defaults, by words alone. Throws Error when a model, or a drive that is not
/// optional, cannot be opened, and insufficientData when a drive has fewer places, or an odd number of
/// images.
Findings mapTours(const ToursOptions& options, Grid& grid, const ExperimentRun& run, Progress& progress);

Findings toursFindings(const DriveResults& results);

}  // namespace estancia::experiments
