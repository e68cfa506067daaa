// The drawing of a map: driven path, transitions, nodes.
#pragma once

#include "estancia/report/heat_map.hpp"
#include "estancia/report/html.hpp"
#include "estancia/report/layout.hpp"
#include "estancia/report/map_page.hpp"
#include "estancia/report/summary.hpp"

namespace estancia::report {

struct FigureStyle {
  double width = 780, height = 580;  ///< CSS pixels; the height is the most there may be
  double fontSize = 12;
  bool words = true;  ///< a node's best word under its room
  std::string name;   ///< class of the <svg>
};

/// An <svg> in which every node is a link to `#node-<id>` and carries its position as data-node.
/// `byHeat` paints the nodes with `heat`, else with their rooms.
Markup mapFigure(const MapSummary& summary, const MapLayout& layout, const HeatMap& heat, bool byHeat,
                 const FloorPlan* plan, FigureStyle style);

/// Rooms with their colours and shapes.
Markup roomLegend(const MapSummary& summary);

/// A node's symbol with its id, as it is on the map.
Markup nodeBadge(const MapSummary& summary, const NodeSummary& node);

}  // namespace estancia::report
