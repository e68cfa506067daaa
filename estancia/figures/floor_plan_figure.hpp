// Floor plan figure: the building as the ground of a metric drawing.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "estancia/figures/floor_plan.hpp"
#include "estancia/figures/html.hpp"
#include "estancia/figures/layout.hpp"

namespace estancia::report {

/// Draws the image, or floors, walls, doors as gaps in them, windows as double lines, and the names of rooms
/// in letters of `nameSize` pixels (0: none).
void drawFloorPlan(Markup& svg, const FloorPlan& plan, const Fit& fit, double nameSize);

/// The corners of the plan [m], which a drawing has to have room for.
std::vector<Point> cornersOf(const FloorPlan& plan);

/// Throws Error where the frames cannot be drawn on it: none has a position (insufficientData), or fewer than
/// half of those that have one lie in rooms (mismatch), as when the trajectory has another origin.
void requireFitting(const FloorPlan& plan, const std::vector<std::optional<Point>>& frames);

}  // namespace estancia::report
