// Revisit experiment: is a mapped drive back where it was when the map reports a return, and does the map
// report all returns?
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "estancia/core/frame.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/findings/findings.hpp"
#include "estancia/map_file/map.hpp"
#include "runner/drive_grid.hpp"
#include "runner/experiment.hpp"
#include "runner/grid.hpp"
#include "runner/subjects.hpp"

namespace estancia {

class ConfigFile;

}  // namespace estancia

namespace estancia::experiments {

/// Whether two frames, which have poses, were taken within so many meters and degrees of each other.
bool isNear(const Frame& a, const Frame& b, double meters, double degrees);

/// Measures of a map's reported returns.
struct Revisits {
  /// Frames within 0.7 m and 30° of one from before the robot was 1.4 m or 60° away; those of them whose node
  /// holds such a one.
  std::size_t frames = 0, found = 0;
  /// Decisions to return, and those to a node without an earlier image within 1 m and 45°.
  std::size_t decisions = 0, wrong = 0;
  /// The first of `frames`, and the first of `found`.
  std::optional<std::size_t> first, firstFound;
};

/// Measures `map`, made of `frames`, which have the true poses. O(frames²). Throws Error: mismatch unless
/// each frame was mapped; insufficientData for a frame without a pose.
Revisits revisitsIn(const std::vector<Frame>& frames, const TopologicalMap& map);

struct RevisitsOptions {
  struct Drive {
    NamedDrive itself;
    /// Driven from its last frame to its first.
    bool isReversed = false;
    /// A drive that follows.
    std::optional<SequenceSource> then;
  };
  /// Names, folders, several joined by +; none: all that are installed.
  std::vector<std::string> models;
  std::vector<Drive> drives;
};

/// Throws Error `file:line: …` on unknown, missing or wrong keys.
RevisitsOptions readRevisits(ConfigFile& config);

/// model,drive,variant,frames,back,found,recall,decisions,wrong,precision,first,first_found
GridColumns revisitsColumns();

/// Maps each drive with the defaults, with its poses and without. Throws Error when a model, or a drive that
/// is not optional, cannot be opened, and as revisitsIn() does.
Findings compareRevisits(const RevisitsOptions& options, Grid& grid, const ExperimentRun& run,
                         Progress& progress);

Findings revisitsFindings(const DriveResults& results);

}  // namespace estancia::experiments
