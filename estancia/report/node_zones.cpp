// SPDX-License-Identifier: Apache-2.0
#include "estancia/report/node_zones.hpp"

#include <fmt/format.h>

#include <set>

#include "estancia/figures/symbols.hpp"
#include "estancia/stats/moments.hpp"

namespace estancia::report {

ClassStyle NodeZones::styleOf(std::size_t node) const {
  return nodes[node] ? zones.list[nodes[node]->zone].style : plainStyle();
}

GroupedRun groupedRun(const TopologicalMap& map) {
  GroupedRun run{{}, map.vocabulary, {}};
  for (const MappedFrame& frame : map.frames) run.frames.push_back({frame.name, frame.node});
  Moments mean(map.vocabulary.size(), false);
  for (const Node& node : map.nodes) mean.add(node.mean, static_cast<double>(node.frames));
  run.mean.assign(mean.mean().begin(), mean.mean().end());
  return run;
}

NodeZones zonesOf(const MapSummary& summary, const Zones& zones) {
  const std::vector<GroupZones> groups = overlayZones(zones, groupedRun(*summary.map));
  NodeZones result{summarize(zones), {}};
  for (const NodeSummary& node : summary.nodes) {
    auto& entry = result.nodes.emplace_back();
    if (const GroupZones* group = findGroup(groups, node.node->id))
      entry =
          NodeZone{static_cast<std::size_t>(group->zone()),
                   static_cast<double>(group->shares.front().frames) / static_cast<double>(group->frames)};
  }
  return result;
}

Markup zoneLegend(const NodeZones& zones) {
  std::set<std::size_t> present;
  bool others = false;
  for (const auto& node : zones.nodes)
    if (node && node->zone < zones.zones.styled)
      present.insert(node->zone);
    else
      others = true;
  Markup legend;
  legend.open("ul", {{"class", "rooms"}});
  for (const std::size_t zone : present)
    legend.open("li")
        .add(symbol(zones.zones.list[zone].style))
        .text(fmt::format("{} {}", zone, shorten(zones.zones.list[zone].name, 60)))
        .close();
  if (others) legend.open("li").add(symbol(plainStyle())).text("smaller zones").close();
  return legend.close();
}

Markup zoneLine(const NodeZones& zones, std::size_t node) {
  Markup line;
  const auto& entry = zones.nodes[node];
  if (!entry) return line;
  line.open("p", {{"class", "in-zone"}}).add(symbol(zones.styleOf(node)));
  return line
      .text(fmt::format("In zone {}, {}: {:.0f} % of its images", entry->zone,
                        zones.zones.list[entry->zone].name, 100 * entry->share))
      .close();
}

}  // namespace estancia::report
