// Findings of the maps experiment: tables, curves and maps side by side, the thesis author's beside.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>

#include "estancia/findings/findings.hpp"
#include "places/map_image.hpp"
#include "places/maps.hpp"
#include "runner/drive_grid.hpp"

namespace estancia::experiments {

/// A ground a name of a sequence, without those that are optional and not there. Throws Error as
/// openImages(), readFloorPlan() and readHomeFloorPlan() do.
std::map<std::string, MapGround> groundsOf(const MapsOptions& options);

/// `results` has a variant a setting, `grounds` its drives.
Findings mapsFindings(const MapsOptions& options, const DriveResults& results,
                      const std::map<std::string, MapGround>& grounds);

}  // namespace estancia::experiments
