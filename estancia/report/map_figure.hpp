// The drawing of a map: driven path, transitions, nodes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <numeric>

#include "estancia/figures/driven_path.hpp"
#include "estancia/figures/layout.hpp"
#include "estancia/report/map_page.hpp"
#include "estancia/report/zone_summary.hpp"

namespace estancia::report {

struct HeatMap {
  std::size_t label = 0;
  std::vector<float> values;  ///< p̄_N(l), one a node of the map; 0 where it is not a number
  float largest = 0;          ///< the largest of the values

  Color colorOf(std::size_t node) const { return viridis(largest > 0 ? values[node] / largest : 0); }
  /// Nodes in falling order of the value, at most `count`, none with 0.
  std::vector<std::size_t> ranking(std::size_t count) const;
};

/// Positions of the values in falling order; equal ones stay in theirs.
template <class T>
std::vector<std::size_t> largestFirst(const std::vector<T>& values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::ranges::greater{}, [&](std::size_t i) { return values[i]; });
  return order;
}

/// Throws Error when the vocabulary has no such label.
HeatMap heatMapOf(const TopologicalMap& map, std::size_t label);

/// The label that distinguishes places best: the largest standard deviation over the nodes.
std::size_t distinctiveLabel(const TopologicalMap& map);

/// Color scale with numbers at 0, the middle and the largest value.
Markup heatLegend(const HeatMap& heat);

/// The meaning of the nodes' colors and shapes.
enum class Painting { heat, rooms, zones };

/// The meanings that one map allows.
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
