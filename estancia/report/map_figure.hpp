// The drawing of a map: driven path, transitions, nodes.
#pragma once

#include "estancia/report/driven_path.hpp"
#include "estancia/report/heat_map.hpp"
#include "estancia/report/html.hpp"
#include "estancia/report/layout.hpp"
#include "estancia/report/map_page.hpp"
#include "estancia/report/node_zones.hpp"
#include "estancia/report/summary.hpp"

namespace estancia::report {

/// What the nodes' colors and shapes tell.
enum class Painting { heat, rooms, zones };

/// What they may tell of one map.
struct MapColors {
  const HeatMap& heat;     ///< colors only; the shapes are those of the rooms
  const NodeZones* zones;  ///< nullptr where none are known
  Painting painting = Painting::rooms;

  ClassStyle styleOf(const MapSummary& summary, std::size_t node) const;
  /// The shapes that a node may be shown in.
  std::vector<std::size_t> sampleSegments(const MapSummary& summary, std::size_t node) const;
};

/// An <svg> in which every node is a link to `#node-<id>` and carries its position as data-node.
Markup mapFigure(const MapSummary& summary, const MapLayout& layout, const MapColors& colors,
                 const FloorPlan* plan, FigureStyle style);

/// Rooms with their colors and shapes.
Markup roomLegend(const MapSummary& summary);

}  // namespace estancia::report
