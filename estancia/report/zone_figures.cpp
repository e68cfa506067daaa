// SPDX-License-Identifier: Apache-2.0
#include "estancia/report/zone_figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <tuple>

#include "estancia/figures/label_places.hpp"

namespace estancia::report {
namespace {

constexpr std::size_t maxSymbols = 1500;  // more cover each other

using Cell = std::pair<long, long>;

Cell cellOf(const Point& p, double side) {
  return {std::lround(p.x / side), std::lround(p.y / side)};
}

/// One symbol a zone and cell, in cells just large enough, and larger than `side`.
std::vector<ZoneSymbol> thinned(const std::vector<ZoneSymbol>& symbols, std::size_t most, double side) {
  std::vector<ZoneSymbol> kept = symbols;
  for (; kept.size() > most && side < 1000; side *= 1.25) {
    std::set<std::tuple<std::size_t, long, long>> taken;
    kept.clear();
    for (const ZoneSymbol& symbol : symbols) {
      const auto [x, y] = cellOf(symbol.at, side);
      if (taken.emplace(symbol.zone, x, y).second) kept.push_back(symbol);
    }
  }
  return kept;
}

/// How densely a zone's symbols stand around each of them, the densest first.
std::vector<std::size_t> densest(const std::vector<ZoneSymbol>& symbols,
                                 const std::vector<std::size_t>& members) {
  constexpr double near = 40;
  std::vector<std::pair<std::size_t, std::size_t>> counts;  // neighbors, symbol
  for (const std::size_t a : members) {
    std::size_t count = 0;
    for (const std::size_t b : members)
      if (std::hypot(symbols[a].at.x - symbols[b].at.x, symbols[a].at.y - symbols[b].at.y) < near) ++count;
    counts.emplace_back(count, a);
  }
  std::ranges::stable_sort(counts, [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<std::size_t> order;
  for (const auto& [count, symbol] : counts) order.push_back(symbol);
  return order;
}

/// The path in the middle of the figure, which becomes as low as it can. `border`: for what sticks out.
Fit fitPath(const std::vector<Point>& extent, double border, FigureStyle& style) {
  const double side = figureMargin + border + 2 * style.fontSize;
  const double top = figureMargin + border + style.fontSize, below = 1.4 * style.fontSize;  // for the scale
  const auto fitNow = [&] {
    return fitInto(extent, {side, top, style.width - 2 * side, style.height - 2 * top - below}, false);
  };
  style.height = neededHeight(fitNow(), extent, style, 2 * top + below);
  return fitNow();
}

/// How far symbols lie outside of the box around the path.
double overhang(const std::vector<ZoneSymbol>& symbols, const std::vector<Point>& extent, const Fit& fit) {
  Box box{fit(extent.front()).x, fit(extent.front()).y, 0, 0};
  for (const Point& point : extent) {
    const Point p = fit(point);
    const double right = std::max(box.x + box.width, p.x), low = std::max(box.y + box.height, p.y);
    box.x = std::min(box.x, p.x);
    box.y = std::min(box.y, p.y);
    box.width = right - box.x;
    box.height = low - box.y;
  }
  double most = 0;
  for (const auto& [p, zone] : symbols)
    most = std::max({most, box.x - p.x, p.x - box.x - box.width, box.y - p.y, p.y - box.y - box.height});
  return most;
}

/// One outline a zone, small zones above large ones: what is rare is not hidden.
void drawSymbols(Markup& svg, const ZonesSummary& summary, const std::vector<ZoneSymbol>& symbols,
                 double radius) {
  std::vector<std::string> outlines(summary.styled + 1);
  const auto styleOf = [&summary](std::size_t zone) {
    return zone < summary.styled ? summary.list[zone].style : plainStyle();
  };
  for (const ZoneSymbol& symbol : symbols)
    outlines[symbol.zone] += shapePath(styleOf(symbol.zone).shape,
                                       symbol.zone < summary.styled ? radius : 0.7 * radius, symbol.at);
  const auto draw = [&](std::size_t zone) {
    if (outlines[zone].empty()) return;
    summary.openMark(svg, zone, "zone");
    svg.leaf("path", {{"d", outlines[zone]}, {"fill", styleOf(zone).fill.hex()}}).close();
  };
  draw(summary.styled);
  for (std::size_t zone = 0; zone < summary.styled; ++zone) draw(zone);
}

/// Numbers and words beside the zones' symbols, the largest zone first, as far as there is room.
void drawNames(Markup& svg, const ZonesSummary& summary, const std::vector<ZoneSymbol>& symbols,
               double radius, const Box& scale, const FigureStyle& style) {
  std::vector<Point> centers;
  std::vector<double> radii;
  std::vector<std::vector<std::size_t>> members(summary.styled + 1);
  for (std::size_t i = 0; i < symbols.size(); ++i) {
    centers.push_back(symbols[i].at);
    radii.push_back(radius);
    members[symbols[i].zone].push_back(i);
  }
  LabelPlaces places(style.width, style.height, centers, radii);
  places.block(scale);
  const auto tryName = [&](std::size_t zone, const std::string& text) {
    const double width = 1.2 * style.fontSize * textWidth(text), height = 1.2 * style.fontSize;
    constexpr std::size_t tries = 24;
    const std::vector<std::size_t> order = densest(symbols, members[zone]);
    for (std::size_t i = 0; i < std::min(tries, order.size()); ++i)
      if (const auto place =
              places.take(order[i * order.size() / std::min(tries, order.size())], width, height)) {
        svg.element("text",
                    {{"class", "room"},
                     {"x", place->x},
                     {"y", place->box.y + 0.95 * style.fontSize},
                     {"text-anchor", place->anchor},
                     {"font-size", style.fontSize},
                     {"data-zone", zone}},
                    text);
        return true;
      }
    return false;
  };
  for (std::size_t zone = 0; zone < summary.styled; ++zone)
    if (!members[zone].empty() &&
        !tryName(zone, fmt::format("{} {}", zone, shorten(summary.list[zone].word, 18))))
      tryName(zone, std::to_string(zone));
}

}  // namespace

std::vector<ZoneSymbol> placeSymbols(const std::vector<std::optional<Point>>& points,
                                     const std::vector<std::size_t>& zoneOf, double gap, std::size_t most) {
  std::vector<ZoneSymbol> symbols;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (points[i]) symbols.push_back({*points[i], zoneOf[i]});
  symbols = thinned(symbols, most, 0.5 * gap);

  std::map<Cell, std::vector<std::size_t>> together;
  for (std::size_t i = 0; i < symbols.size(); ++i) together[cellOf(symbols[i].at, 1)].push_back(i);
  for (auto& [cell, group] : together) {
    std::ranges::stable_sort(group, {}, [&symbols](std::size_t i) { return symbols[i].zone; });
    const Point middle = symbols[group.front()].at;
    for (std::size_t k = 0; k < group.size(); ++k) {
      const double reach = group.size() == 1 ? 0 : 0.55 * gap * std::sqrt(static_cast<double>(k) + 0.3);
      const double angle = 2.399963 * static_cast<double>(k);  // the golden angle
      symbols[group[k]].at = {middle.x + reach * std::cos(angle), middle.y + reach * std::sin(angle)};
    }
  }
  return symbols;
}

Markup zoneFigure(const ZonesSummary& summary, const DrivenPath& path, FigureStyle style,
                  const FloorPlan* plan) {
  std::vector<Point> extent;
  for (const auto& point : path.points)
    if (point) extent.push_back(*point);
  const std::size_t images = extent.size();
  if (plan != nullptr)
    for (const Point& corner : cornersOf(*plan)) extent.push_back(corner);
  std::vector<std::size_t> zoneOf;
  for (const int zone : summary.zones->zoneOf)
    zoneOf.push_back(std::min(static_cast<std::size_t>(zone), summary.styled));

  const double area = style.width * style.height;
  const std::size_t most = std::min(maxSymbols, static_cast<std::size_t>(area / 120));
  const double radius =
      std::clamp(0.15 * std::sqrt(area / static_cast<double>(std::min(images, most))), 3.0, 6.0);
  const auto symbolsOf = [&](const Fit& fit) {
    std::vector<std::optional<Point>> points;
    for (const auto& point : path.points) points.push_back(point ? std::optional(fit(*point)) : std::nullopt);
    return placeSymbols(points, zoneOf, 2.5 * radius, most);
  };
  // Marks around a place at the border need room, known once they are drawn.
  FigureStyle first = style;
  Fit fit = fitPath(extent, radius, first);
  fit = fitPath(extent, radius + overhang(symbolsOf(fit), extent, fit), style);
  const std::vector<ZoneSymbol> symbols = symbolsOf(fit);

  Markup svg = openFigure(
      "map", style,
      fmt::format("{} in {} from above", counted(images, "image"), counted(summary.list.size(), "zone")));
  if (plan != nullptr) drawFloorPlan(svg, *plan, fit, style.fontSize);
  drawPath(svg, path.points, fit);
  const Box scale = drawScale(svg, fit.scale, style);
  drawSymbols(svg, summary, symbols, radius);
  drawNames(svg, summary, symbols, radius, scale, style);
  return svg.close();
}

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
    std::vector<double> numbers;  // where
    const std::string text = std::to_string(zone);
    for (const Stay* stay : staysIn[zone]) {
      const auto across = [&](std::size_t frame) {
        return style.width * static_cast<double>(frame) / static_cast<double>(zoneOf.size());
      };
      const double from = across(stay->first), whole = across(stay->last + 1) - from;
      const double wide = whole > 4 ? whole - 1 : whole;  // a seam between stays, where they can be seen
      path.move(from, 0).line(from + wide, 0).line(from + wide, foot - 4).line(from, foot - 4).close();
      if (zone < summary.styled && style.fontSize * textWidth(text) + 3 < wide)
        numbers.push_back(from + wide / 2);
    }
    svg.leaf("path", {{"d", path.str()}, {"fill", look.fill.hex()}});
    for (const double x : numbers)
      svg.element("text",
                  {{"x", x},
                   {"y", (foot - 4) / 2 + 0.36 * style.fontSize},
                   {"text-anchor", "middle"},
                   {"font-size", style.fontSize},
                   {"fill", look.fill.ink()}},
                  text);
    svg.close();
  }
  drawAxis(svg, zoneOf.size(), foot, style);
  return svg.close();
}

RoomCounts countRooms(const Zones& zones, std::size_t columns) {
  const std::size_t wide = std::min(columns + 1, zones.zones.size());
  std::map<std::string, std::vector<std::size_t>> byRoom;
  for (std::size_t i = 0; i < zones.frames.size(); ++i) {
    if (zones.frames[i].room.empty()) continue;
    auto& row = byRoom.try_emplace(zones.frames[i].room, wide).first->second;
    ++row[std::min(static_cast<std::size_t>(zones.zoneOf[i]), wide - 1)];
  }
  std::vector<std::pair<std::string, std::vector<std::size_t>>> rows(byRoom.begin(), byRoom.end());
  std::ranges::stable_sort(
      rows, {}, [](const auto& row) { return std::ranges::max_element(row.second) - row.second.begin(); });
  RoomCounts result;
  for (auto& [room, counts] : rows) {
    result.rooms.push_back(room);
    result.counts.push_back(std::move(counts));
  }
  return result;
}

Markup roomTable(const ZonesSummary& summary, const RoomCounts& counts) {
  constexpr std::size_t maxRows = 200;
  Markup table;
  table.open("div", {{"class", "scroll"}, {"tabindex", "0"}}).open("table", {{"class", "numbers counts"}});
  table.open("thead").open("tr").element("th", {{"scope", "col"}}, "room");
  const std::size_t columns = counts.counts.empty() ? 0 : counts.counts.front().size();
  for (std::size_t zone = 0; zone < columns; ++zone) {
    table.open("th", {{"scope", "col"}});
    if (zone + 1 == columns && columns < summary.list.size()) {
      table.text("others").close();
      continue;
    }
    table.open("a", {{"href", fmt::format("#zone-{}", zone)}, {"title", summary.describe(zone)}});
    table.add(symbol(summary.list[zone].style)).text(std::to_string(zone)).close().close();
  }
  table.close().close().open("tbody");
  for (std::size_t row = 0; row < std::min(maxRows, counts.rooms.size()); ++row) {
    const auto& cells = counts.counts[row];
    const auto images = static_cast<double>(std::accumulate(cells.begin(), cells.end(), std::size_t{0}));
    table.open("tr").element("th", {{"scope", "row"}}, shorten(counts.rooms[row], 40));
    for (const std::size_t count : cells) {
      constexpr double dark = 0.88;  // from here on white reads better than black
      const double share = static_cast<double>(count) / images;
      if (count == 0)
        table.element("td", "");
      else
        table.element("td",
                      {{"class", share > dark ? "most" : "some"}, {"style", "--share:" + number(share)}},
                      grouped(count));
    }
    table.close();
  }
  table.close().close().close();
  if (counts.rooms.size() > maxRows)
    table.element("p", {{"class", "note"}},
                  fmt::format("{} more are not shown.", counted(counts.rooms.size() - maxRows, "room")));
  return table;
}

}  // namespace estancia::report
