// Plan shapes: the areas and walls of a floor plan as outlines.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estancia/areas/area_plan.hpp"
#include "estancia/figures/layout.hpp"

namespace estancia::report {

/// Closed lines in the floor's axes [m]: what an odd number of them surrounds is inside.
using Outlines = std::vector<std::vector<Point>>;

struct PlanShapes {
  /// The free floor of each area, in the order of AreaPlan::areas.
  std::vector<Outlines> areas;
  Outlines walls;
};

/// Traces the cells of a plan, to half a cell; a plan of more than 1500 cells a side more coarsely.
PlanShapes shapesOf(const AreaPlan& plan);

/// Path of a figure, for fill-rule evenodd.
std::string pathOf(const Outlines& outlines, const Fit& fit);

}  // namespace estancia::report
