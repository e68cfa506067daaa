// Map image: a topological map over the driven path and the floor plan, small enough to stand beside
// others. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "estancia/figures/floor_plan.hpp"
#include "estancia/figures/layout.hpp"
#include "runner/grid.hpp"

namespace estancia::experiments {

/// What lies under the maps of one sequence.
struct MapGround {
  report::DrivenPath path;
  /// In alphabetical order: each has a color.
  std::vector<std::string> rooms;
  std::optional<FloorPlan> floorPlan;
};

/// A PNG of the nodes and links that a cell of the maps experiment holds: nodes at the mean of their images,
/// as large as they have images, in the color of their room, which a wide one names. Empty without positions.
std::vector<unsigned char> drawMap(const CellResults& map, const MapGround& ground, bool isWide);

}  // namespace estancia::experiments
