// Floor plan: the building under the drawing of a map.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estancia/report/html.hpp"
#include "estancia/report/layout.hpp"
#include "estancia/report/map_page.hpp"

namespace estancia::report {

/// Draws the image, or floors, walls, doors as gaps in them, windows as double lines, and the names of rooms
/// in letters of `nameSize` pixels (0: none).
void drawFloorPlan(Markup& svg, const FloorPlan& plan, const Fit& fit, double nameSize);

/// Throws Error where the map cannot be drawn on it: no poses (insufficientData), or fewer than half of the
/// posed frames lie in rooms (mismatch), as when the trajectory has another origin.
void requireFitting(const FloorPlan& plan, const MapLayout& layout);

}  // namespace estancia::report
