// Known objects experiment: made-up models that are put into real depth frames, and such as are not there.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "estancia/core/progress.hpp"
#include "estancia/findings/findings.hpp"
#include "recognition/depth_frames.hpp"
#include "runner/experiment.hpp"
#include "runner/grid.hpp"

namespace estancia {

class ConfigFile;

}  // namespace estancia

namespace estancia::experiments {

struct KnownObjectsOptions {
  std::vector<DepthFrameSource> sources;
  /// Even frames are for choosing, odd ones for reporting.
  std::vector<std::string> halves{"choosing", "reporting"};
  /// Only these; none: all.
  std::vector<std::string> families;
  std::string preset = "default";
  /// Largest mean distance of a right pose's points from the true surface (ADD-S of Hinterstoisser et al.,
  /// ACCV 2012), as a share of the diameter.
  double distance = 0.1;
  std::uint64_t seed = 1;
};

/// Throws Error `file:line: …` on unknown, missing or wrong keys.
KnownObjectsOptions readKnownObjects(ConfigFile& config);

/// frames,half,scene,task,part,searched,accepted,wrong,maybe,refused,seconds
GridColumns knownObjectsColumns();

/// Looks for each model alone: in each frame as it is, and for one model of each family in a frame that it
/// was put into. Throws Error as readFrame() does.
Findings compareKnownObjects(const KnownObjectsOptions& options, Grid& grid, const ExperimentRun& run,
                             Progress& progress);

}  // namespace estancia::experiments
