// Zone summary: what a page shows of each zone, and of zones laid over the nodes of a map.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "estancia/figures/color.hpp"
#include "estancia/figures/html.hpp"
#include "estancia/figures/summary.hpp"
#include "estancia/map_file/map.hpp"
#include "estancia/zones/overlay.hpp"
#include "estancia/zones/zones.hpp"

namespace estancia::report {

struct ZoneSummary {
  const Zone* zone = nullptr;  ///< zone of the summarized zones
  ClassStyle style;
  double share = 0;               ///< share of all images, 0 … 1
  std::string name;               ///< its most distinctive labels, short enough for a page
  std::string word;               ///< the first of them
  std::vector<VisitSpan> visits;  ///< ascending, uninterrupted stays
};

struct ZonesSummary {
  const Zones* zones = nullptr;
  std::vector<ZoneSummary> list;  ///< in the order of Zones::zones: the largest first, position = id
  std::size_t styled = 0;         ///< the first so many have a style of their own, all others share one

  /// "Zone 3, corridor: 120 images, 12.5 %"
  std::string describe(std::size_t zone) const;

  /// Opens what a drawing shows of a zone: a link to `#zone-<id>` that carries the id as data-zone, or, for
  /// the zones without a style of their own (`zone` ≥ styled), a group.
  void openMark(Markup& svg, std::size_t zone, const std::string& kind) const;
};

/// `zones` must outlive the summary.
ZonesSummary summarize(const Zones& zones);

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
