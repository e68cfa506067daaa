// Object segmentation experiment: are the objects in an image found, whole and apart (thesis 6.3)?
// docs/measured/objects.md shows the tables that it makes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "estancia/core/camera.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/findings/findings.hpp"
#include "runner/experiment.hpp"
#include "runner/grid.hpp"

namespace estancia {

class ConfigFile;

}  // namespace estancia

namespace estancia::experiments {

struct ObjectSegmentationOptions {
  /// See readObjectScenes(); empty where they are made up.
  std::filesystem::path scenes;
  /// Scenes that are made up, see madeUpScene(), and the seed of the first.
  std::size_t madeUp = 0;
  std::uint64_t firstScene = 1;
  CameraIntrinsics camera;
  /// Units a meter of the depth images; 0: the usual.
  double depthScale = 0;
  /// Seed of the planes and of the posters' noise.
  std::uint64_t seed = 1;
  /// Number of the best scenes on the page, and of the worst.
  std::size_t images = 3;
};

/// Throws Error `file:line: …` on unknown, missing or wrong keys.
ObjectSegmentationOptions readObjectSegmentation(ConfigFile& config);

/// scene,objects,found,over,under,mean_iou,posters,posters_told,taken_for_flat,euclidean_found, …
GridColumns objectSegmentationColumns();

/// Runs the experiment. Throws Error when the scenes are not there or an image cannot be read.
Findings segmentObjects(const ObjectSegmentationOptions& options, Grid& grid, const ExperimentRun& run,
                        Progress& progress);

}  // namespace estancia::experiments
