// World figure: the floor plan of a map with areas, walls, the driven path and objects.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estancia/figures/driven_path.hpp"
#include "estancia/figures/html.hpp"
#include "estancia/figures/plan_shapes.hpp"
#include "estancia/report/world_view.hpp"

namespace estancia::report {

/// An <svg> in which every object is a link to `#object-<id>` and carries its number as data-object: a small
/// image (imageSymbols()) where there is room, else a dot. Areas link to `#area-<id>`. Its attribute data-fit
/// gives the transform from meters to pixels ("scale from-x from-y to-x to-y"; y of the floor grows upwards),
/// and has an empty <g class="way"> for the script. `shapes`: empty for a map without a plan.
Markup worldFigure(const WorldView& view, const PlanShapes& shapes, FigureStyle style);

}  // namespace estancia::report
