// SPDX-License-Identifier: Apache-2.0
#include "estancia/report/zone_figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "estancia/figures/floor_plan_figure.hpp"
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
  std::stable_sort(counts.begin(), counts.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<std::size_t> order;
  for (const auto& [count, symbol] : counts) order.push_back(symbol);
  return order;
}

/// The path in the middle of the figure, which becomes as low as that allows. `border` is for what sticks
/// out.
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
  const auto outside = [&box](const Point& p) {
    return std::max({box.x - p.x, p.x - box.x - box.width, box.y - p.y, p.y - box.y - box.height});
  };
  for (const Point& point : extent) {
    const Point p = fit(point);
    const double right = std::max(box.x + box.width, p.x), low = std::max(box.y + box.height, p.y);
    box.x = std::min(box.x, p.x);
    box.y = std::min(box.y, p.y);
    box.width = right - box.x;
    box.height = low - box.y;
  }
  double most = 0;
  for (const ZoneSymbol& symbol : symbols) most = std::max(most, outside(symbol.at));
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
    std::stable_sort(group.begin(), group.end(),
                     [&symbols](std::size_t a, std::size_t b) { return symbols[a].zone < symbols[b].zone; });
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

}  // namespace estancia::report
