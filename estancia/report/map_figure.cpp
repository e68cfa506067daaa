#include "estancia/report/map_figure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace estancia::report {
namespace {

constexpr double margin = 14;
/// Width for the id inside a symbol, in radii, by ClassStyle::shape.
constexpr std::array<double, 5> textRoom{1.4, 1.4, 1.15, 1.4, 1.05};
/// How far a symbol reaches from its middle, in radii.
constexpr std::array<double, 5> reachOf{1, 1, 1.26, 1.1, 1.3};

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

/// Room for labels: what is already there must not be covered.
class LabelPlaces {
 public:
  LabelPlaces(const FigureStyle& style, const std::vector<Point>& nodes, const std::vector<double>& extents,
              const std::vector<Link>& links)
      : frame_{4, 4, style.width - 8, style.height - 8}, nodes_(nodes), extents_(extents), links_(links) {}

  /// The best of eight places round a node for a box of this size, touching no node and no other label, and
  /// as few transitions as can be; nothing when there is none.
  std::optional<Box> take(std::size_t node, double width, double height) {
    constexpr std::array<std::array<int, 2>, 8> sides{
        {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {1, -1}, {-1, 1}, {-1, -1}}};
    std::optional<Box> best;
    double bestCost = 1e9;
    for (std::size_t side = 0; side < sides.size(); ++side) {
      const auto [dx, dy] = sides[side];
      const double reach = (extents_[node] + 4) * (dx != 0 && dy != 0 ? std::sqrt(0.5) : 1);
      const double x = nodes_[node].x + dx * (reach + width / 2);
      const double y = nodes_[node].y + dy * (reach + height / 2);
      const Box box{x - width / 2, y - height / 2, width, height};
      if (!isFree(box)) continue;
      double cost = 0.1 * static_cast<double>(side);
      for (const Link& link : links_)
        if (box.crosses(nodes_[link.a], nodes_[link.b])) cost += 1;
      if (cost < bestCost) {
        bestCost = cost;
        best = box;
      }
    }
    if (best) taken_.push_back(*best);
    return best;
  }

  void block(const Box& box) { taken_.push_back(box); }

 private:
  bool isFree(const Box& box) const {
    if (!box.inside(frame_)) return false;
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      if (box.overlapsCircle(nodes_[i], extents_[i] + 3)) return false;
    return std::none_of(taken_.begin(), taken_.end(),
                        [&box](const Box& other) { return other.overlaps(box); });
  }

  Box frame_;
  const std::vector<Point>& nodes_;
  const std::vector<double>& extents_;
  const std::vector<Link>& links_;
  std::vector<Box> taken_;
};

/// As high as the drawing needs at this scale, within reason: a flat map leaves no empty card.
double neededHeight(const Fit& fit, const std::vector<Point>& extent, const FigureStyle& style,
                    double borders) {
  double low = fit.to.y, high = fit.to.y;
  for (const Point& p : extent) {
    low = std::min(low, fit(p).y);
    high = std::max(high, fit(p).y);
  }
  return std::clamp(std::ceil(high - low + borders), 0.55 * style.width, style.height);
}

void drawFloorPlan(Markup& svg, const FloorPlan& plan, const Fit& fit) {
  const Point corner = fit({plan.xMin, plan.yMax});
  svg.leaf("image", {{"class", "plan"},
                     {"href", imageUri(plan.image, "the floor plan")},
                     {"x", corner.x},
                     {"y", corner.y},
                     {"width", (plan.xMax - plan.xMin) * fit.scale},
                     {"height", (plan.yMax - plan.yMin) * fit.scale},
                     {"preserveAspectRatio", "none"}});
}

/// The driven path, thinned to steps one can see.
void drawPath(Markup& svg, const std::vector<std::optional<Point>>& frames, const Fit& fit) {
  constexpr double step = 1.5;
  Path path;
  std::optional<Point> last;
  for (const auto& frame : frames) {
    if (!frame) {
      last.reset();
      continue;
    }
    const Point p = fit(*frame);
    if (last && std::hypot(p.x - last->x, p.y - last->y) < step) continue;
    last ? path.line(p.x, p.y) : path.move(p.x, p.y);
    last = p;
  }
  if (!path.empty()) svg.leaf("path", {{"class", "driven"}, {"d", path.str()}});
}

/// A bar of 1, 2 or 5 · 10ⁿ metres, at most a fifth of the width.
Box drawScale(Markup& svg, double scale, const FigureStyle& style) {
  const double most = 0.2 * style.width / scale;
  double metres = std::pow(10, std::floor(std::log10(most)));
  for (const double factor : {5.0, 2.0})
    if (factor * metres <= most) {
      metres *= factor;
      break;
    }
  const double x = margin, y = style.height - margin, length = metres * scale;
  svg.leaf("path",
           {{"class", "scale"},
            {"d", Path().move(x, y - 5).line(x, y).line(x + length, y).line(x + length, y - 5).str()}});
  svg.element("text", {{"class", "scale-text"}, {"x", x + 6}, {"y", y - 6}, {"font-size", style.fontSize}},
              significant(metres) + " m");
  return {x, y - 8 - style.fontSize, std::max(length, 50.0), 8 + style.fontSize};
}

std::string describe(const NodeSummary& node) {
  return fmt::format("Node {}{}: {}, {}", node.node->id,
                     node.room.empty() ? "" : ", " + shorten(node.room, 40), shorten(node.title, 40),
                     counted(node.node->frames, "frame"));
}

void drawNode(Markup& svg, const MapSummary& summary, std::size_t n, const Point& at, double radius,
              const Colour& fill) {
  const NodeSummary& node = summary.nodes[n];
  const std::string id = std::to_string(node.node->id);
  const std::size_t shape = summary.styleOf(node).shape;
  const double size = std::min(12.5, textRoom[shape] * radius / std::max(textWidth(id), 0.8));
  svg.open("a", {{"class", "node"},
                 {"href", "#node-" + id},
                 {"data-node", n},
                 {"transform", fmt::format("translate({} {})", number(at.x, 1), number(at.y, 1))},
                 {"aria-label", describe(node)}});
  svg.element("title", describe(node));
  if (radius >= 9 && radius < 12) svg.leaf("circle", {{"r", 12}, {"fill", "transparent"}});  // for fingers
  svg.leaf("path", {{"d", shapePath(shape, radius)}, {"fill", fill.hex()}});
  if (radius >= 8) svg.element("text", {{"y", 0.35 * size}, {"font-size", size}, {"fill", fill.ink()}}, id);
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
  const double side = plan != nullptr ? margin : margin + largest + 2.4 * style.fontSize;
  const double top = plan != nullptr ? margin : margin + largest + style.fontSize;
  const double below = layout.metric && plan == nullptr ? 1.2 * style.fontSize : 0;  // for the scale

  std::vector<Point> extent = layout.nodes;
  for (const auto& frame : layout.frames)
    if (frame) extent.push_back(*frame);
  if (plan != nullptr) extent.insert(extent.end(), {{plan->xMin, plan->yMin}, {plan->xMax, plan->yMax}});
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
           {margin, margin, style.width - 2 * margin, style.height - 2 * margin});
  return result;
}

/// Names rooms once, at their largest node, and nodes by their best word, wherever there is space.
void drawLabels(Markup& svg, const MapSummary& summary, const Placement& placement,
                const std::vector<std::size_t>& order, LabelPlaces& places, const FigureStyle& style) {
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
    const auto box = places.take(n, width, height);
    if (!box) continue;
    const double lean = box->x + width / 2 - placement.nodes[n].x;  // text begins or ends at its node
    const std::string anchor = std::abs(lean) < 1 ? "middle" : lean > 0 ? "start" : "end";
    const double x = anchor == "middle" ? placement.nodes[n].x : anchor == "start" ? box->x : box->x + width;
    const auto line = [&](const char* kind, double y, double fontSize, const std::string& text) {
      svg.element("text",
                  {{"class", kind}, {"x", x}, {"y", y}, {"text-anchor", anchor}, {"font-size", fontSize}},
                  text);
    };
    if (!room.empty()) line("room", box->y + 0.95 * size, size, room);
    if (!word.empty()) line("word", box->y + height - 0.28 * small, small, word);
  }
}

}  // namespace

Markup mapFigure(const MapSummary& summary, const MapLayout& layout, const HeatMap& heat, bool byHeat,
                 const FloorPlan* plan, FigureStyle style) {
  const Placement placement = place(summary, layout, plan, style);
  const auto& [fit, nodes, radii] = placement;

  Markup svg;
  svg.open("svg", {{"class", "map " + style.name},
                   {"viewBox", fmt::format("0 0 {} {}", number(style.width), number(style.height))},
                   {"role", "group"},
                   {"aria-label", "Map of " + counted(summary.nodes.size(), "node") + " and " +
                                      counted(summary.links.size(), "link")}});
  if (plan != nullptr) drawFloorPlan(svg, *plan, fit);
  drawPath(svg, layout.frames, fit);
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

  std::vector<std::size_t> order(nodes.size());  // small nodes on top, large ones labelled first
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  const auto larger = [&radii = placement.radii](std::size_t a, std::size_t b) {
    return radii[a] > radii[b];
  };
  std::stable_sort(order.begin(), order.end(), larger);
  std::vector<double> extents;
  for (std::size_t n = 0; n < nodes.size(); ++n)
    extents.push_back(radii[n] * reachOf[summary.styleOf(summary.nodes[n]).shape]);
  LabelPlaces places(style, nodes, extents, summary.links);
  if (layout.metric) places.block(drawScale(svg, fit.scale, style));
  for (const std::size_t n : order)
    drawNode(svg, summary, n, nodes[n], radii[n],
             byHeat ? heat.colourOf(n) : summary.styleOf(summary.nodes[n]).fill);
  drawLabels(svg, summary, placement, order, places, style);
  return svg.close();
}

Markup roomLegend(const MapSummary& summary) {
  Markup legend;
  legend.open("ul", {{"class", "rooms"}});
  for (const std::string& room : summary.rooms) {
    const ClassStyle& style = summary.roomStyles.at(room);
    legend.open("li").open("svg", {{"viewBox", "-10 -10 20 20"}, {"aria-hidden", "true"}});
    legend.leaf("path", {{"d", shapePath(style.shape, 7)}, {"fill", style.fill.hex()}}).close();
    legend.text(shorten(room, 40)).close();
  }
  return legend.close();
}

Markup nodeBadge(const MapSummary& summary, const NodeSummary& node) {
  const ClassStyle style = summary.styleOf(node);
  const std::string id = std::to_string(node.node->id);
  Markup badge;
  badge.open("svg", {{"class", "badge"}, {"viewBox", "-20 -20 40 40"}, {"aria-hidden", "true"}});
  badge.leaf("path", {{"d", shapePath(style.shape, 15)}, {"fill", style.fill.hex()}});
  badge.element("text",
                {{"y", 4.5}, {"font-size", std::min(13.0, 22 / textWidth(id))}, {"fill", style.fill.ink()}},
                id);
  return badge.close();
}

}  // namespace estancia::report
