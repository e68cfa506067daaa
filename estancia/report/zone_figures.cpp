// SPDX-License-Identifier: Apache-2.0
#include "estancia/report/zone_figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <tuple>

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

using Branch = DendrogramTop::Branch;

/// The twigs from left to right as the tree hangs; by a stack, as trees may be as deep as they are wide.
std::vector<std::size_t> inOrder(const std::vector<Branch>& branches) {
  std::vector<std::size_t> twigs, stack{branches.size() - 1};
  while (!stack.empty()) {
    const std::size_t at = stack.back();
    stack.pop_back();
    if (!branches[at].left) {
      twigs.push_back(at);
      continue;
    }
    stack.push_back(*branches[at].right);
    stack.push_back(*branches[at].left);
  }
  return twigs;
}

/// Where everything is: heights across, twigs down.
struct Plot {
  double left, right, top, foot;  ///< edges of the plot
  double highest;                 ///< distance at the left edge

  double x(double height) const { return right - (right - left) * std::clamp(height / highest, 0.0, 1.0); }
};

/// Rows of the twigs: those of one zone close together, zones far enough apart for their names.
std::vector<double> rowsOf(const DendrogramTop& top, double line, double& foot) {
  std::vector<double> rows(top.branches.size());
  const auto zoneOf = [&top](std::size_t i) { return top.branches[top.twigs[i]].zone; };
  for (std::size_t i = 0; i < top.twigs.size();) {
    std::size_t end = i + 1;
    while (end < top.twigs.size() && zoneOf(i) && zoneOf(end) == zoneOf(i)) ++end;
    const auto count = static_cast<double>(end - i);
    const double room = std::max(line, 0.55 * line * count + 0.3 * line);
    for (std::size_t twig = i; twig < end; ++twig)
      rows[top.twigs[twig]] = foot + room * (static_cast<double>(twig - i) + 0.5) / count;
    foot += room;
    i = end;
  }
  for (std::size_t b = 0; b < rows.size(); ++b)
    if (top.branches[b].left) rows[b] = (rows[*top.branches[b].left] + rows[*top.branches[b].right]) / 2;
  return rows;
}

void drawAxis(Markup& svg, const Plot& plot, const FigureStyle& style) {
  const double step = niceStep(plot.highest, (plot.right - plot.left) / 90);
  for (double height = 0; height <= plot.highest * 1.0001; height += step) {
    const double x = plot.x(height);
    svg.leaf("path", {{"class", "grid"}, {"d", Path().move(x, plot.top).line(x, plot.foot).str()}});
    addText(svg, "scale-text", {x, plot.foot + 1.3 * style.fontSize}, style.fontSize - 1, number(height, 6),
            "middle");
  }
}

void drawCut(Markup& svg, const Plot& plot, double cut, const FigureStyle& style) {
  const double x = plot.x(cut);
  svg.leaf("path", {{"class", "cut"}, {"d", Path().move(x, plot.top - 4).line(x, plot.foot).str()}});
  const std::string text = "cut " + significant(cut);
  const double half = 0.55 * style.fontSize * textWidth(text);
  addText(svg, "cut-text", {std::clamp(x, half + 2, style.width - half - 2), plot.top - 8}, style.fontSize,
          text, "middle");
}

/// The lines of a branch down to its parts; a twig that holds more than one item ends in a wedge.
void addLines(const DendrogramTop& top, std::size_t b, const std::vector<double>& rows, const Plot& plot,
              Path& lines, Path& wedges) {
  const Branch& branch = top.branches[b];
  const double x = plot.x(branch.height), y = rows[b];
  if (!branch.left) {
    if (branch.items > 1) wedges.move(x, y).line(plot.x(0), y - 2.5).line(plot.x(0), y + 2.5).close();
    return;
  }
  for (const std::size_t part : {*branch.left, *branch.right})
    lines.move(x, y).line(x, rows[part]).line(plot.x(top.branches[part].height), rows[part]);
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

DendrogramTop topOf(const Dendrogram& dendrogram, const std::vector<int>& zoneOf, std::size_t merges) {
  const std::size_t leaves = dendrogram.leaves(), count = dendrogram.merges().size();
  const std::size_t firstShown = leaves + count - std::min(count, merges);
  // clusters below `firstShown` are drawn as twigs: which of them each item is in, from the top down
  std::vector<std::size_t> twigOf(leaves + count);
  twigOf.back() = twigOf.size() - 1;
  for (std::size_t c = leaves + count; c-- > leaves;) {
    const auto& merge = dendrogram.merges()[c - leaves];
    for (const std::size_t part : {merge.left, merge.right})
      twigOf[part] = c >= firstShown ? part : twigOf[c];
  }
  std::map<std::size_t, std::set<int>> zonesOf;  // zones of the twigs
  for (std::size_t i = 0; i < leaves; ++i) zonesOf[twigOf[i]].insert(zoneOf[i]);

  DendrogramTop top;
  std::map<std::size_t, std::size_t> positions;  // positions of clusters
  for (const auto& [cluster, zones] : zonesOf) {
    Branch twig;
    twig.items = cluster < leaves ? 1 : dendrogram.merges()[cluster - leaves].size;
    twig.height = cluster < leaves ? 0 : dendrogram.merges()[cluster - leaves].height;
    twig.zones = zones.size();
    twig.firstZone = *zones.begin();
    if (zones.size() == 1) twig.zone = twig.firstZone;
    positions[cluster] = top.branches.size();
    top.branches.push_back(twig);
  }
  for (std::size_t c = firstShown; c < leaves + count; ++c) {
    const auto& merge = dendrogram.merges()[c - leaves];
    std::size_t first = positions.at(merge.left), second = positions.at(merge.right);
    if (top.branches[second].firstZone < top.branches[first].firstZone) std::swap(first, second);
    Branch branch{first, second, merge.height, merge.size, {}, 0, top.branches[first].firstZone};
    if (top.branches[first].zone == top.branches[second].zone) branch.zone = top.branches[first].zone;
    positions[c] = top.branches.size();
    top.branches.push_back(branch);
  }
  top.twigs = inOrder(top.branches);
  return top;
}

/// The merges below one zone, in its color, with its symbol and name.
static void drawZone(Markup& svg, const ZonesSummary& summary, const DendrogramTop& top, int zone,
                     const std::vector<std::size_t>& branches, const std::vector<double>& rows,
                     const Plot& plot, const FigureStyle& style) {
  const Zones& zones = *summary.zones;
  const auto z = static_cast<std::size_t>(zone);
  const ZoneSummary& entry = summary.list[z];
  const double y = rows[branches.back()];  // its topmost merge
  Path lines, own;
  for (const std::size_t b : branches) addLines(top, b, rows, plot, lines, own);
  const Branch& whole = top.branches[branches.back()];
  lines.move(plot.x(whole.height), y).line(plot.x(std::max(whole.height, zones.cut)), y);
  summary.openMark(svg, z, "zone");
  svg.leaf("path", {{"class", "branch"}, {"d", lines.str()}, {"stroke", entry.style.fill.hex()}});
  if (!own.empty())
    svg.leaf("path", {{"class", "wedge"},
                      {"d", own.str()},
                      {"fill", entry.style.fill.hex()},
                      {"stroke", entry.style.fill.hex()}});
  const double x = plot.right + 0.9 * style.fontSize;
  svg.leaf("path", {{"class", "mark"},
                    {"d", shapePath(entry.style.shape, 0.42 * style.fontSize, {x, y})},
                    {"fill", entry.style.fill.hex()}});
  const double room = style.width - x - style.fontSize;
  const std::string text = fmt::format("{} {}", zone, style.words ? entry.name : entry.word);
  addText(svg, "name", {x + 0.8 * style.fontSize, y + 0.35 * style.fontSize}, style.fontSize,
          shortenToWidth(text, room / (1.12 * style.fontSize)));
  svg.close();
}

Markup dendrogramFigure(const ZonesSummary& summary, FigureStyle style) {
  const Zones& zones = *summary.zones;
  const DendrogramTop top = topOf(*zones.dendrogram, zones.zoneOf, 60);
  const double line = 1.35 * style.fontSize, names = style.words ? 0.36 * style.width : 0.42 * style.width;
  const double highest = std::max(top.branches.back().height, 1.02 * zones.cut);
  Plot plot{18, style.width - names, 2.2 * style.fontSize, 0, highest > 0 ? highest : 1};
  plot.foot = plot.top;
  const std::vector<double> rows = rowsOf(top, line, plot.foot);
  plot.foot += 6;
  style.height = plot.foot + 3 * style.fontSize;

  Markup svg = openFigure("tree", style,
                          fmt::format("Dendrogram: the top {} of {}", top.twigs.size() - 1,
                                      counted(zones.dendrogram->merges().size(), "merge")));
  drawAxis(svg, plot, style);
  addText(svg, "scale-text", {plot.left, style.height - 0.4 * style.fontSize}, style.fontSize,
          "distance at which two become one");

  Path above, wedges;
  std::map<int, std::vector<std::size_t>> ofZone;  // branches
  for (std::size_t b = 0; b < top.branches.size(); ++b)
    if (const auto& zone = top.branches[b].zone)
      ofZone[*zone].push_back(b);
    else
      addLines(top, b, rows, plot, above, wedges);
  svg.leaf("path", {{"class", "branch"}, {"d", above.str()}});
  svg.leaf("path", {{"class", "wedge"}, {"d", wedges.str()}});
  for (const auto& [zone, branches] : ofZone) drawZone(svg, summary, top, zone, branches, rows, plot, style);
  for (const std::size_t twig : top.twigs)
    if (!top.branches[twig].zone)
      addText(svg, "scale-text", {plot.right + 0.6 * style.fontSize, rows[twig] + 0.35 * style.fontSize},
              style.fontSize,
              fmt::format("zone {} and {}", top.branches[twig].firstZone,
                          counted(top.branches[twig].zones - 1, "other")));
  drawCut(svg, plot, zones.cut, style);
  return svg.close();
}

}  // namespace estancia::report
