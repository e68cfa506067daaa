// The drawing of a map: driven path, transitions, nodes.
#pragma once

#include "estancia/report/driven_path.hpp"
#include "estancia/report/heat_map.hpp"
#include "estancia/report/html.hpp"
#include "estancia/report/layout.hpp"
#include "estancia/report/map_page.hpp"
#include "estancia/report/summary.hpp"

namespace estancia::report {

/// An <svg> in which every node is a link to `#node-<id>` and carries its position as data-node.
/// `byHeat` paints the nodes with `heat`, else with their rooms.
Markup mapFigure(const MapSummary& summary, const MapLayout& layout, const HeatMap& heat, bool byHeat,
                 const FloorPlan* plan, FigureStyle style);

/// Rooms with their colours and shapes.
Markup roomLegend(const MapSummary& summary);

}  // namespace estancia::report
