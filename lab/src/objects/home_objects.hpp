// Home objects: are the things of a furnished home in the map, each as one instance?
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "objects/home_segmentation.hpp"

namespace estancia::experiments {

/// Runs the experiment over drives with true poses. A thing counts where at least `minFramesOfThing` frames
/// show `minPixels` of its pixels, and is found where an instance's box has an intersection over union of
/// 0.25 or more with its own. Instances that are things of the class "fixture", or hang at a wall, count
/// neither way. The options are those of readHomeSegmentation(). Throws Error when a drive has no poses, or
/// as segmentHomes().
Findings findHomeObjects(const HomeSegmentationOptions& options, Grid& grid, const ExperimentRun& run,
                         Progress& progress);

/// drive,noise,class,things,found,instances,right,error,split,merged
GridColumns homeObjectColumns();

}  // namespace estancia::experiments
