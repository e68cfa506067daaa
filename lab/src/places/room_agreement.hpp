// Room agreement experiment: places and zones of drives against the rooms stood in and the rooms seen.
// SPDX-License-Identifier: Apache-2.0
#pragma once

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

struct RoomAgreementOptions {
  /// Names, folders, several joined by +; none: all that are installed.
  std::vector<std::string> models;
  /// How the frames of a drive are clustered: names of clusterings(); none: all.
  std::vector<std::string> methods;
  std::vector<NamedDrive> drives;
};

/// Throws Error `file:line: …` on unknown, missing or wrong keys.
RoomAgreementOptions readRoomAgreement(ConfigFile& config);

/// model,drive,method,frames,rooms,looks_elsewhere,clusters,v_measure,ari,purity,seen_v_measure, …
GridColumns roomAgreementColumns();

/// Clusters every drive by every method, with its defaults. The rooms that are seen are those of the
/// home.json in the folder of a drive; unknown without one. Throws Error when a model, or a drive that is not
/// optional, cannot be opened.
Findings compareWithRooms(const RoomAgreementOptions& options, Grid& grid, const ExperimentRun& run,
                          Progress& progress);

Findings roomAgreementFindings(const DriveResults& results);

}  // namespace estancia::experiments
