#include "estancia/report/zone_legend.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "estancia/report/symbols.hpp"

namespace estancia::report {
namespace {

Markup entries(const ZonesSummary& summary, std::size_t begin, std::size_t end) {
  Markup list;
  list.open("ol", {{"class", "zones"}, {"start", begin}});
  for (std::size_t zone = begin; zone < end; ++zone) {
    const ZoneSummary& entry = summary.list[zone];
    list.open("li").open("a", {{"href", fmt::format("#zone-{}", zone)}, {"data-zone", zone}});
    list.add(symbol(entry.style)).element("b", std::to_string(zone)).element("span", entry.name);
    list.element("span", {{"class", "p"}}, fmt::format("{:.1f} %", 100 * entry.share));
    list.open("span", {{"class", "bar"}});
    const double part = entry.share / summary.list.front().share;
    list.element(
        "i",
        {{"style", fmt::format("width:{}%;background:{}", number(100 * part, 1), entry.style.fill.hex())}},
        "");
    list.close().close().close();
  }
  return list.close();
}

}  // namespace

Markup zoneLegend(const ZonesSummary& summary) {
  constexpr std::size_t open = 30;
  const std::size_t shown = summary.styled <= open + 5 ? summary.styled : open;  // a few are not worth a fold
  Markup legend = entries(summary, 0, shown);
  if (shown < summary.styled) {
    legend.open("details").element("summary", counted(summary.styled - shown, "smaller zone"));
    legend.add(entries(summary, shown, summary.styled)).close();
  }
  if (summary.styled < summary.list.size()) {
    const std::size_t images = summary.imagesUnstyled();
    legend.open("p", {{"class", "rest"}}).add(symbol(plainStyle()));
    legend.text(fmt::format(
        "{} still smaller, {:.1f} % of the images", counted(summary.list.size() - summary.styled, "zone"),
        100.0 * static_cast<double>(images) / static_cast<double>(summary.zones->frames.size())));
    legend.close();
  }
  return legend;
}

}  // namespace estancia::report
