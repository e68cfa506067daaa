// Zones of nodes: zones laid over the nodes of a map.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "estancia/figures/html.hpp"
#include "estancia/figures/summary.hpp"
#include "estancia/map_file/map.hpp"
#include "estancia/report/zone_summary.hpp"
#include "estancia/zones/overlay.hpp"

namespace estancia::report {

/// The map's frames and words, for overlayZones().
GroupedRun groupedRun(const TopologicalMap& map);

struct NodeZone {
  std::size_t zone = 0;  ///< zone of most of the node's frames
  double share = 0;      ///< share of its frames that are in it
};

struct NodeZones {
  ZonesSummary zones;
  /// one a node, in the order of MapSummary::nodes; none for a node without frames
  std::vector<std::optional<NodeZone>> nodes;

  ClassStyle styleOf(std::size_t node) const;
};

/// Throws Error when the zones are of another run than the map.
NodeZones zonesOf(const MapSummary& summary, const Zones& zones);

/// The zones that nodes are in, with their symbols, numbers and words.
Markup zoneLegend(const NodeZones& zones);

/// "▲ In zone 3, corridor, lobby: 80 % of its images"; empty when nothing is known of the node.
Markup zoneLine(const NodeZones& zones, std::size_t node);

}  // namespace estancia::report
