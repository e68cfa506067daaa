// SPDX-License-Identifier: Apache-2.0
#include "estancia/figures/decision_chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace estancia::report {
namespace {

constexpr std::size_t columns = 1000;  // columns of the plot; the browser stretches them to its width
constexpr double plotHeight = 240;

struct Scale {
  double lastFrame = 1, top = 1;

  double x(double frame) const { return frame / lastFrame * static_cast<double>(columns); }
  double y(double distance) const { return plotHeight * (1 - std::clamp(distance / top, 0.0, 1.0)); }
};

std::vector<double> column(const std::vector<Decision>& decisions, double Decision::*member) {
  std::vector<double> values(decisions.size());
  std::ranges::transform(decisions, values.begin(), member);
  return values;
}

double largestOf(const std::vector<Decision>& decisions) {
  double largest = 0;
  for (const Decision& d : decisions)
    for (const double value : {d.toCurrent, d.toOther, d.tauJoin, d.tauRevisit})
      if (std::isfinite(value)) largest = std::max(largest, value);
  return largest > 0 && largest < 1e12 ? largest : 1;
}

void drawLine(Markup& svg, const char* kind, const std::vector<double>& values, const Scale& scale) {
  Path path;
  bool drawing = false;
  for (const Point& p : thinned(values, columns)) {
    const bool known = !std::isnan(p.y);
    if (known) drawing ? path.line(scale.x(p.x), scale.y(p.y)) : path.move(scale.x(p.x), scale.y(p.y));
    drawing = known;
  }
  if (!path.empty()) svg.leaf("path", {{"class", kind}, {"d", path.str()}});
}

/// Dots as lines of no length with round ends: they stay round when the plot is stretched. One a column.
void drawDots(Markup& svg, const char* kind, const std::vector<Point>& dots, const Scale& scale) {
  std::map<int, double> highest;
  for (const Point& dot : dots) {
    auto& y = highest.try_emplace(static_cast<int>(2 * scale.x(dot.x)), dot.y).first->second;
    y = std::max(y, dot.y);
  }
  Path path;
  for (const auto& [x, y] : highest) path.move(x / 2.0, scale.y(y)).line(x / 2.0, scale.y(y));
  if (!path.empty()) svg.leaf("path", {{"class", kind}, {"d", path.str()}});
}

Markup legend(bool merges) {
  Markup list;
  list.open("ul", {{"class", "chart-legend"}});
  const auto entry = [&list](const char* kind, const char* what) {
    list.open("li").open("svg", {{"viewBox", "0 0 26 12"}, {"aria-hidden", "true"}});
    const bool dot = std::string_view(kind).ends_with("dot");
    const bool upright = std::string_view(kind) == "merge";
    list.leaf("path", {{"class", kind}, {"d", dot ? "M13 6L13 6" : upright ? "M13 0L13 12" : "M1 6L25 6"}});
    list.close().text(what).close();
  };
  entry("to-current", "distance to the current node");
  entry("to-other", "to the nearest other node");
  entry("tau-join", "τ join");
  entry("tau-revisit", "τ revisit");
  entry("split-dot", "new node");
  entry("revisit-dot", "moved to a known node");
  if (merges) entry("merge", "two nodes merged");
  return list.close();
}

}  // namespace

std::vector<Point> thinned(const std::vector<double>& values, std::size_t columnCount) {
  std::vector<Point> points;
  const std::size_t n = values.size();
  const auto finite = [&values](std::size_t i) { return std::isfinite(values[i]); };
  const auto at = [&](std::size_t i) {
    return Point{static_cast<double>(i), finite(i) ? values[i] : std::numeric_limits<double>::quiet_NaN()};
  };
  if (n <= 2 * columnCount) {
    for (std::size_t i = 0; i < n; ++i) points.push_back(at(i));
    return points;
  }
  for (std::size_t column = 0; column < columnCount; ++column) {
    const std::size_t begin = column * n / columnCount, end = (column + 1) * n / columnCount;
    std::size_t low = end, high = end;
    for (std::size_t i = begin; i < end; ++i) {
      if (!finite(i)) continue;
      if (low == end || values[i] < values[low]) low = i;
      if (high == end || values[i] > values[high]) high = i;
    }
    points.push_back(at(low == end ? begin : std::min(low, high)));
    if (low != high) points.push_back(at(std::max(low, high)));
  }
  return points;
}

Markup decisionChart(const TopologicalMap& map) {
  const auto& decisions = map.decisions;
  const double largest = largestOf(decisions);
  const double step = niceStep(largest, 4);
  const Scale scale{std::max(1.0, static_cast<double>(decisions.size()) - 1), 1.05 * largest};

  std::vector<Point> splits, revisits;
  for (std::size_t i = 0; i < decisions.size(); ++i) {
    const Decision& d = decisions[i];
    const auto x = static_cast<double>(i);
    if (d.kind == DecisionKind::createNode && std::isfinite(d.toCurrent)) splits.push_back({x, d.toCurrent});
    if (d.kind == DecisionKind::revisit && std::isfinite(d.toOther)) revisits.push_back({x, d.toOther});
  }

  Markup figure;
  figure.open("figure", {{"class", "chart"}}).add(legend(!map.merges.empty()));
  figure.open("div", {{"class", "plot"}}).open("div", {{"class", "ticks-y"}, {"aria-hidden", "true"}});
  for (double value = 0; value <= scale.top; value += step)
    figure.element("span", {{"style", fmt::format("top:{}%", number(100 * scale.y(value) / plotHeight))}},
                   significant(value));
  figure.close();
  figure.open("svg",
              {{"class", decisions.size() > columns ? "dense" : "sparse"},
               {"viewBox", fmt::format("0 0 {} {}", columns, plotHeight)},
               {"preserveAspectRatio", "none"},
               {"role", "img"},
               {"aria-label",
                fmt::format("Distances of {} to the nodes: {}, {}, {}", counted(decisions.size(), "frame"),
                            counted(splits.size(), "split"), counted(revisits.size(), "revisit"),
                            counted(map.merges.size(), "merge"))}});
  for (double value = 0; value <= scale.top; value += step)
    figure.leaf("path", {{"class", "grid"},
                         {"d", Path().move(0, scale.y(value)).line(columns, scale.y(value)).str()}});
  for (const Merge& merge : map.merges) {
    const double x = scale.x(static_cast<double>(merge.frame));
    figure.leaf("path", {{"class", "merge"}, {"d", Path().move(x, 0).line(x, plotHeight).str()}});
  }
  drawLine(figure, "to-other", column(decisions, &Decision::toOther), scale);
  drawLine(figure, "to-current", column(decisions, &Decision::toCurrent), scale);
  drawLine(figure, "tau-join", column(decisions, &Decision::tauJoin), scale);
  drawLine(figure, "tau-revisit", column(decisions, &Decision::tauRevisit), scale);
  drawDots(figure, "revisit-dot", revisits, scale);
  drawDots(figure, "split-dot", splits, scale);
  figure.close().open("div", {{"class", "ticks-x"}, {"aria-hidden", "true"}});
  const double frameStep = std::max(1.0, niceStep(scale.lastFrame, 5));
  for (double frame = 0; frame <= scale.lastFrame; frame += frameStep)
    figure.element("span", {{"style", fmt::format("left:{}%", number(scale.x(frame) / columns * 100))}},
                   grouped(static_cast<std::size_t>(frame)));
  figure.close().close();
  figure.element(
      "figcaption",
      fmt::format("Frame number across, {} distance up. A frame joins its current node below "
                  "τ join, moves to a nearer known node below τ revisit, and else founds a new node.",
                  map.distance.empty() ? "descriptor" : shorten(map.distance, 60)));
  return figure.close();
}

}  // namespace estancia::report
