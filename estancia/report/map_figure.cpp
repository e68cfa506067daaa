// SPDX-License-Identifier: Apache-2.0
#include "estancia/report/map_figure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "estancia/core/fail.hpp"

namespace estancia::report {
namespace {

/// The radius of the largest node: small enough for all nodes to find room.
double largestRadius(std::size_t nodes, const FigureStyle& style) {
  const double cell = std::sqrt(style.width * style.height / static_cast<double>(nodes + 1));
  return std::clamp(0.2 * cell, 2.5, 26.0);
}

/// Radii whose squares grow with the nodes' frames; the smallest can still be hit and read.
std::vector<double> radiiOf(const MapSummary& summary, double largest) {
  std::uint64_t most = 1;
  for (const NodeSummary& node : summary.nodes) most = std::max(most, node.node->frames);
  std::vector<double> radii;
  for (const NodeSummary& node : summary.nodes) {
    const double part = static_cast<double>(node.node->frames) / static_cast<double>(most);
    radii.push_back(std::max(largest * std::sqrt(part), std::min(largest, std::max(0.4 * largest, 9.0))));
  }
  return radii;
}

std::string describe(const NodeSummary& node) {
  return fmt::format("Node {}{}: {}, {}", node.node->id,
                     node.room.empty() ? "" : ", " + shorten(node.room, 40), shorten(node.title, 40),
                     counted(node.node->frames, "frame"));
}

void drawNode(Markup& svg, const MapSummary& summary, std::size_t n, const Point& at, double radius,
              const MapColors& colors) {
  const NodeSummary& node = summary.nodes[n];
  const std::string id = std::to_string(node.node->id);
  const ClassStyle look = colors.styleOf(summary, n);
  double room = 2;
  for (const std::size_t shape : colors.sampleSegments(summary, n)) room = std::min(room, textRoom(shape));
  const double size = std::min(12.5, room * radius / std::max(textWidth(id), 0.8));
  svg.open("a", {{"class", "node"},
                 {"href", "#node-" + id},
                 {"data-node", n},
                 {"transform", fmt::format("translate({} {})", number(at.x, 1), number(at.y, 1))},
                 {"aria-label", describe(node)}});
  svg.element("title", describe(node));
  if (radius >= 9 && radius < 12) svg.leaf("circle", {{"r", 12}, {"fill", "transparent"}});  // for fingers
  svg.leaf("path", {{"d", shapePath(look.shape, unitRadius)},
                    {"transform", fmt::format("scale({})", number(radius / unitRadius, 3))},
                    {"fill", look.fill.hex()}});
  if (radius >= 8)
    svg.element("text", {{"y", 0.35 * size}, {"font-size", size}, {"fill", look.fill.ink()}}, id);
  svg.close();
}

/// Where everything is in the figure.
struct Placement {
  Fit fit;
  std::vector<Point> nodes;
  std::vector<double> radii;
};

/// Lowers `style.height` to what the drawing needs.
Placement place(const MapSummary& summary, const MapLayout& layout, const FloorPlan* plan,
                FigureStyle& style) {
  double largest = largestRadius(summary.nodes.size(), style);
  const double side = plan != nullptr ? figureMargin : figureMargin + largest + 2.4 * style.fontSize;
  const double top = plan != nullptr ? figureMargin : figureMargin + largest + style.fontSize;
  const bool edged = plan == nullptr || plan->home;  // an image may lie under the scale, a wall may not
  const double below = layout.metric && edged ? 1.2 * style.fontSize : 0;

  std::vector<Point> extent = layout.nodes;
  for (const auto& frame : layout.frames)
    if (frame) extent.push_back(*frame);
  if (plan != nullptr)
    for (const Point& corner : cornersOf(*plan)) extent.push_back(corner);
  const auto fitNow = [&] {
    return fitInto(extent, {side, top, style.width - 2 * side, style.height - 2 * top - below},
                   !layout.metric);
  };
  style.height = neededHeight(fitNow(), extent, style, 2 * top + below);

  Placement result{fitNow(), {}, {}};
  for (const Point& node : layout.nodes) result.nodes.push_back(result.fit(node));
  std::vector<double> lengths;  // half of the transitions should be seen between their nodes
  for (const Link& link : summary.links)
    lengths.push_back(std::hypot(result.nodes[link.a].x - result.nodes[link.b].x,
                                 result.nodes[link.a].y - result.nodes[link.b].y));
  if (!lengths.empty()) {
    const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
    std::nth_element(lengths.begin(), middle, lengths.end());
    largest = std::min(largest, std::max(0.32 * *middle, 11.0));
  }
  result.radii = radiiOf(summary, largest);
  separate(result.nodes, result.radii, std::min(6.0, 0.4 * largest),
           {figureMargin, figureMargin, style.width - 2 * figureMargin, style.height - 2 * figureMargin});
  return result;
}

/// Names rooms once, at their largest node, and nodes by their best word, wherever there is space.
void drawLabels(Markup& svg, const MapSummary& summary, const std::vector<std::size_t>& order,
                LabelPlaces& places, const FigureStyle& style) {
  std::set<std::string> named;
  for (const std::size_t n : order) {
    const NodeSummary& node = summary.nodes[n];
    const bool nameRoom = !node.room.empty() && named.insert(node.room).second;
    const std::string room = nameRoom ? shorten(node.room, 22) : "";
    const std::string word = style.words || summary.rooms.empty() ? shorten(node.title, 22) : "";
    if (room.empty() && word.empty()) continue;
    const double size = style.fontSize, small = room.empty() ? size - 1 : size - 2;
    const double width = 1.08 * std::max(size * 1.06 * textWidth(room), small * textWidth(word));
    const double height = (room.empty() ? 0 : 1.2 * size) + (word.empty() ? 0 : 1.2 * small);
    const auto place = places.take(n, width, height);
    if (!place) continue;
    const auto& [box, x, anchor] = *place;
    if (!room.empty()) addText(svg, "room", {x, box.y + 0.95 * size}, size, room, anchor);
    if (!word.empty()) addText(svg, "word", {x, box.y + height - 0.28 * small}, small, word, anchor);
  }
}

}  // namespace

ClassStyle MapColors::styleOf(const MapSummary& summary, std::size_t node) const {
  if (painting == Painting::zones && zones != nullptr) return zones->styleOf(node);
  ClassStyle look = summary.styleOf(summary.nodes[node]);
  if (painting == Painting::heat) look.fill = heat.colorOf(node);
  return look;
}

std::vector<std::size_t> MapColors::sampleSegments(const MapSummary& summary, std::size_t node) const {
  std::vector<std::size_t> shapes{summary.styleOf(summary.nodes[node]).shape};
  if (zones != nullptr) shapes.push_back(zones->styleOf(node).shape);
  return shapes;
}

Markup mapFigure(const MapSummary& summary, const MapLayout& layout, const MapColors& colors,
                 const FloorPlan* plan, FigureStyle style) {
  const Placement placement = place(summary, layout, plan, style);
  const auto& [fit, nodes, radii] = placement;

  Markup svg = openFigure(
      "map", style,
      "Map of " + counted(summary.nodes.size(), "node") + " and " + counted(summary.links.size(), "link"));
  if (plan != nullptr) drawFloorPlan(svg, *plan, fit, summary.rooms.empty() ? style.fontSize : 0);
  drawPath(svg, layout.frames, fit, layout.driveStarts);
  const double thin = std::min(1.5, 0.1 * largestRadius(nodes.size(), style));
  for (const Link& link : summary.links) {
    const Point &a = nodes[link.a], &b = nodes[link.b];
    svg.leaf("path",
             {{"class", "link"},
              {"d", Path().move(a.x, a.y).line(b.x, b.y).str()},
              {"data-ends", fmt::format("{} {}", link.a, link.b)},
              {"stroke-width",
               std::min(6.0, thin * (1 + std::log2(static_cast<double>(link.there + link.back + 1)) / 2))}});
  }

  const std::vector<std::size_t> order = largestFirst(radii);  // small nodes on top, large ones labeled first
  std::vector<double> extents;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    double reach = 1;
    for (const std::size_t shape : colors.sampleSegments(summary, n)) reach = std::max(reach, reachOf(shape));
    extents.push_back(radii[n] * reach);
  }
  std::vector<std::pair<std::size_t, std::size_t>> lines;
  for (const Link& link : summary.links) lines.emplace_back(link.a, link.b);
  LabelPlaces places(style.width, style.height, nodes, extents, lines);
  if (layout.metric) places.block(drawScale(svg, fit.scale, style));
  for (const std::size_t n : order) drawNode(svg, summary, n, nodes[n], radii[n], colors);
  drawLabels(svg, summary, order, places, style);
  return svg.close();
}

Markup roomLegend(const MapSummary& summary) {
  Markup legend;
  legend.open("ul", {{"class", "rooms"}});
  for (const std::string& room : summary.rooms)
    legend.open("li").add(symbol(summary.roomStyles.at(room))).text(shorten(room, 40)).close();
  return legend.close();
}

std::vector<std::size_t> HeatMap::ranking(std::size_t count) const {
  std::vector<std::size_t> order = largestFirst(values);
  order.resize(std::min(count, order.size()));
  while (!order.empty() && values[order.back()] <= 0) order.pop_back();
  return order;
}

HeatMap heatMapOf(const TopologicalMap& map, std::size_t label) {
  if (label >= map.vocabulary.size())
    fail(ErrorCode::invalidInput, "there is no label {} for a heat map; the map has {}", label,
         map.vocabulary.size());
  HeatMap heat{label, {}, 0};
  for (const Node& node : map.nodes) {
    const float value = label < node.mean.size() && node.mean[label] > 0 ? node.mean[label] : 0;
    heat.values.push_back(value);
    heat.largest = std::max(heat.largest, value);
  }
  return heat;
}

std::size_t distinctiveLabel(const TopologicalMap& map) {
  std::size_t best = 0;
  double bestVariance = -1;
  const auto count = static_cast<double>(std::max<std::size_t>(map.nodes.size(), 1));
  for (std::size_t label = 0; label < map.vocabulary.size(); ++label) {
    double sum = 0, squares = 0;
    for (const Node& node : map.nodes) {
      const double value = label < node.mean.size() ? node.mean[label] : 0;
      sum += value;
      squares += value * value;
    }
    const double variance = squares / count - sum / count * (sum / count);
    if (variance > bestVariance) {
      bestVariance = variance;
      best = label;
    }
  }
  return best;
}

Markup heatLegend(const HeatMap& heat) {
  std::string gradient = "background:linear-gradient(90deg";
  for (const Color& color : viridisStops()) gradient += "," + color.hex();
  gradient += ")";
  Markup legend;
  legend.open("div", {{"class", "heat-legend"}});
  legend.element("span", {{"class", "heat-title"}}, "mean probability");
  legend.open("div", {{"class", "heat-scale"}});
  legend.element("i", {{"style", gradient}}, "");
  legend.open("div", {{"class", "heat-ticks"}});
  for (const double part : {0.0, 0.5, 1.0})
    legend.element("span", significant(part * static_cast<double>(heat.largest)));
  return legend.close().close().close();
}

}  // namespace estancia::report
