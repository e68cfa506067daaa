// How likely one label is at each node (thesis 4.4): its values, their colors, its legend.
#pragma once

#include <cstddef>
#include <vector>

#include "estancia/report/color.hpp"
#include "estancia/report/html.hpp"
#include "estancia/topology/map.hpp"

namespace estancia::report {

struct HeatMap {
  std::size_t label = 0;
  std::vector<float> values;  ///< p̄_N(l), one a node of the map; 0 where it is not a number
  float largest = 0;          ///< of the values

  Color colorOf(std::size_t node) const { return viridis(largest > 0 ? values[node] / largest : 0); }
  /// Nodes in falling order of the value, at most `count`, none with 0.
  std::vector<std::size_t> ranking(std::size_t count) const;
};

/// Throws Error when the vocabulary has no such label.
HeatMap heatMapOf(const TopologicalMap& map, std::size_t label);

/// The label that tells places apart best: the largest standard deviation over the nodes.
std::size_t mostTellingLabel(const TopologicalMap& map);

/// Color scale with numbers at 0, the middle and the largest value.
Markup heatLegend(const HeatMap& heat);

}  // namespace estancia::report
