// Further drives: is a drive that follows another one recognized in its map, continued or merged?
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

/// Measures of the second drive in a map of two.
struct FurtherDrive {
  /// Frames of the second drive; within 0.7 m and 30° of one of the first; in a place of the first.
  std::size_t frames = 0, near = 0, known = 0;
  /// Known frames in a place that holds an image of the first drive within a meter; known frames in a place
  /// without one within a meter or of their room: recognized as it when the robot came there, and added to it
  /// while the robot drove on in it.
  std::size_t right = 0, wrong = 0, grown = 0;
  std::optional<std::size_t> firstRight;
  /// Places of the second drive that became one with those of the first when maps were merged.
  std::size_t joined = 0;
  /// Mean distance of the poses in the map to the true ones [m].
  std::optional<double> poseError;
};

/// `truth`: the frames of both with their true poses in one frame and their rooms, in order. `isElsewhere`:
/// the drives were in two buildings, and all that is known is wrong. Throws Error: mismatch unless each frame
/// was mapped; insufficientData for a frame without a pose.
FurtherDrive furtherDriveIn(const std::vector<Frame>& truth, const TopologicalMap& map, bool isElsewhere);

struct FurtherDrivesOptions {
  struct Pair {
    NamedDrive itself;
    SequenceSource then;
    /// Images of the second drive that are left out at its begin.
    std::size_t skipped = 0;
    bool isElsewhere = false;
  };
  /// Names, folders, several joined by +; none: all that are installed.
  std::vector<std::string> models;
  std::vector<Pair> pairs;
};

/// Throws Error `file:line: …` on unknown, missing or wrong keys.
FurtherDrivesOptions readFurtherDrives(ConfigFile& config);

GridColumns furtherDrivesColumns();

/// Maps each first drive with the defaults, and goes on with the second one, or merges the maps of both; with
/// poses (those of the second drive in a frame of its own), by words alone, and with depth where both drives
/// have it. Throws Error when a model, or a drive that is not optional, cannot be opened, and as
/// furtherDriveIn() does.
Findings compareFurtherDrives(const FurtherDrivesOptions& options, Grid& grid, const ExperimentRun& run,
                              Progress& progress);

Findings furtherDrivesFindings(const DriveResults& results);

}  // namespace estancia::experiments
