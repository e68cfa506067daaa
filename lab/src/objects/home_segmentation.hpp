// Home segmentation experiment: the things of a furnished home found by class, and clusters that are none.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "estancia/core/progress.hpp"
#include "estancia/findings/findings.hpp"
#include "estancia/objects/instance_accuracy.hpp"
#include "runner/experiment.hpp"
#include "runner/grid.hpp"

namespace estancia::experiments {

struct HomeSegmentationOptions {
  /// Folders of drives: RGB-D with instance/*.png and instances.csv (home_truth.hpp).
  std::vector<std::string> drives;
  /// Standard deviations of noise that is added to depth [m at 1 m]; it grows with the square of depth.
  std::vector<double> noise = {0};
  /// Takes every such frame.
  std::size_t every = 1;
  /// Pixels with depth of the smallest thing that is to be found.
  std::size_t minPixels = 300;
  std::uint64_t seed = 1;
  ThingClasses classes{.otherClass = "small"};
};

/// What the cells depend on, for their digests.
std::string classesText(const ThingClasses& classes);

/// Throws Error `file:line: …` on unknown, missing or wrong keys.
HomeSegmentationOptions readHomeSegmentation(ConfigFile& config);

/// drive,noise,class,things,found,clusters,right
GridColumns homeSegmentationColumns();

/// Runs the experiment: a thing is found, and a cluster right, where their intersection over union, over
/// pixels with depth, is 0.5 or more. Throws Error when a drive has no masks or cannot be read.
Findings segmentHomes(const HomeSegmentationOptions& options, Grid& grid, const ExperimentRun& run,
                      Progress& progress);

}  // namespace estancia::experiments
