// Are the things in an image found, whole and apart (thesis 6.3)? docs/measured/objects.md shows the
// tables that it makes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "estancia/core/camera.hpp"
#include "estancia/core/progress.hpp"
#include "experiments/src/findings/findings.hpp"
#include "experiments/src/runner/experiment.hpp"
#include "experiments/src/runner/grid.hpp"

namespace estancia {

class ConfigFile;

}  // namespace estancia

namespace estancia::experiments {

struct ObjectSegmentationOptions {
  std::filesystem::path scenes;  ///< see readObjectScenes()
  CameraIntrinsics camera;
  double depthScale = 0;    ///< units a meter of the depth images; 0: the usual
  double tolerance = 0.02;  ///< of plain Euclidean clusters [m]
  std::uint64_t seed = 1;   ///< of planes and of the posters' noise
  std::size_t images = 3;   ///< of the best scenes on the page, and as many of the worst
};

/// Throws Error `file:line: …` on unknown, missing or wrong keys.
ObjectSegmentationOptions readObjectSegmentation(ConfigFile& config);

/// scene,objects,found,over,under,mean_iou,posters,posters_told,taken_for_flat,euclidean_found, …
GridColumns objectSegmentationColumns();

/// Runs the experiment. Throws Error when the scenes are not there or an image cannot be read.
Findings segmentObjects(const ObjectSegmentationOptions& options, Grid& grid, const ExperimentRun& run,
                        Progress& progress);

}  // namespace estancia::experiments
