// SPDX-License-Identifier: Apache-2.0
#include "estancia/report/zone_summary.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "estancia/zones/naming.hpp"

namespace estancia::report {

std::string ZonesSummary::describe(std::size_t zone) const {
  const ZoneSummary& summary = list[zone];
  return fmt::format("Zone {}, {}: {}, {:.1f} %", zone, summary.word,
                     counted(summary.zone->images.size(), "image"), 100 * summary.share);
}

std::size_t ZonesSummary::imagesUnstyled() const {
  std::size_t images = 0;
  for (std::size_t zone = styled; zone < list.size(); ++zone) images += list[zone].zone->images.size();
  return images;
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

}  // namespace estancia::report
