// SPDX-License-Identifier: Apache-2.0
#include "estancia/report/zone_figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "estancia/figures/svg.hpp"

namespace estancia::report {
namespace {

int majorityZone(const std::vector<int>& zoneOf, std::size_t begin, std::size_t end) {
  std::map<int, std::size_t> counts;
  int best = zoneOf[begin];
  for (std::size_t i = begin; i < end; ++i)
    if (++counts[zoneOf[i]] > counts[best]) best = zoneOf[i];
  return best;
}

void drawAxis(Markup& svg, std::size_t frames, double foot, const FigureStyle& style) {
  const double last = std::max(1.0, static_cast<double>(frames) - 1);
  const double step = std::max(1.0, niceStep(last, std::max(2.0, style.width / 140)));
  for (double frame = 0; frame <= last; frame += step) {
    const double x = style.width * frame / static_cast<double>(frames);
    const bool isFirst = frame == 0, isLast = x > style.width - 24;
    svg.leaf("path", {{"class", "scale"}, {"d", Path().move(x, foot).line(x, foot + 4).str()}});
    addText(svg, "scale-text", {x, foot + 6 + style.fontSize}, style.fontSize,
            isFirst ? "image 0" : grouped(static_cast<std::size_t>(frame)),
            isFirst  ? "start"
            : isLast ? "end"
                     : "middle");
  }
}

}  // namespace

std::vector<Stay> staysOf(const std::vector<int>& zoneOf, std::size_t columns) {
  std::vector<Stay> stays;
  columns = std::min(columns, zoneOf.size());
  for (std::size_t column = 0; column < columns; ++column) {
    const std::size_t begin = column * zoneOf.size() / columns, end = (column + 1) * zoneOf.size() / columns;
    const int zone = majorityZone(zoneOf, begin, end);
    if (stays.empty() || stays.back().zone != zone)
      stays.push_back({{begin, end - 1}, zone});
    else
      stays.back().last = end - 1;
  }
  return stays;
}

Markup timeStrip(const ZonesSummary& summary, const FigureStyle& style) {
  const auto& zoneOf = summary.zones->zoneOf;
  const double foot = style.height - 1.8 * style.fontSize;
  const std::vector<Stay> stays = staysOf(zoneOf, static_cast<std::size_t>(style.width));
  std::vector<std::vector<const Stay*>> staysIn(summary.styled + 1);
  for (const Stay& stay : stays)
    staysIn[std::min(static_cast<std::size_t>(stay.zone), summary.styled)].push_back(&stay);

  Markup svg = openFigure("strip", style, fmt::format("{} over the run", counted(stays.size(), "stay")));
  for (std::size_t zone = 0; zone < staysIn.size(); ++zone) {
    if (staysIn[zone].empty()) continue;
    const ClassStyle look = zone < summary.styled ? summary.list[zone].style : plainStyle();
    summary.openMark(svg, zone, "zone");
    Path path;
    std::vector<std::pair<double, std::string>> numbers;  // where and which
    const std::string text = std::to_string(zone);
    for (const Stay* stay : staysIn[zone]) {
      const auto across = [&](std::size_t frame) {
        return style.width * static_cast<double>(frame) / static_cast<double>(zoneOf.size());
      };
      const double from = across(stay->first), whole = across(stay->last + 1) - from;
      const double wide = whole > 4 ? whole - 1 : whole;  // a seam between stays, where they can be seen
      path.move(from, 0).line(from + wide, 0).line(from + wide, foot - 4).line(from, foot - 4).close();
      if (zone < summary.styled && style.fontSize * textWidth(text) + 3 < wide)
        numbers.emplace_back(from + wide / 2, text);
    }
    svg.leaf("path", {{"d", path.str()}, {"fill", look.fill.hex()}});
    for (const auto& [x, label] : numbers)
      svg.element("text",
                  {{"x", x},
                   {"y", (foot - 4) / 2 + 0.36 * style.fontSize},
                   {"text-anchor", "middle"},
                   {"font-size", style.fontSize},
                   {"fill", look.fill.ink()}},
                  label);
    svg.close();
  }
  drawAxis(svg, zoneOf.size(), foot, style);
  return svg.close();
}

}  // namespace estancia::report
