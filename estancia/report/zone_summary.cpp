// SPDX-License-Identifier: Apache-2.0
#include "estancia/report/zone_summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "estancia/stats/moments.hpp"
#include "estancia/zones/naming.hpp"

namespace estancia::report {

std::string ZonesSummary::describe(std::size_t zone) const {
  const ZoneSummary& summary = list[zone];
  return fmt::format("Zone {}, {}: {}, {:.1f} %", zone, summary.word,
                     counted(summary.zone->images.size(), "image"), 100 * summary.share);
}

void ZonesSummary::openMark(Markup& svg, std::size_t zone, const std::string& kind) const {
  if (zone >= styled) {
    svg.open("g", {{"class", kind}}).element("title", "Smaller zones");
    return;
  }
  svg.open("a", {{"class", kind},
                 {"href", fmt::format("#zone-{}", zone)},
                 {"data-zone", zone},
                 {"aria-label", describe(zone)}});
  svg.element("title", describe(zone));
}

ZonesSummary summarize(const Zones& zones) {
  ZonesSummary summary{&zones, {}, std::min(zones.zones.size(), distinctClasses)};
  for (const Zone& zone : zones.zones) {
    ZoneSummary& entry = summary.list.emplace_back();
    const std::size_t position = summary.list.size() - 1;
    entry.zone = &zone;
    entry.style = position < summary.styled ? symbolStyle(position) : plainStyle();
    entry.share = static_cast<double>(zone.images.size()) / static_cast<double>(zones.frames.size());
    entry.name = shorten(describedName(zone), 90);
    entry.word = shorten(shortName(zone), 40);
    for (const std::size_t image : zone.images) addFrame(entry.visits, image);
  }
  return summary;
}

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
  line.text(fmt::format("In zone {}, {}: {:.0f} % of its images", entry->zone,
                        zones.zones.list[entry->zone].name, 100 * entry->share));
  return line.close();
}

}  // namespace estancia::report
