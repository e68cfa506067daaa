// Line chart: curves over a common axis.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "estancia/figures/svg.hpp"
#include "estancia/findings/findings_page.hpp"

namespace estancia {

using namespace report;
namespace {

constexpr double plotWidth = 1000, plotHeight = 280;  // the browser stretches them to its width

/// The classes that color and dash the i-th of many curves: seven colors, then other dashes; 28 in all.
std::string curveClass(std::size_t i) {
  return fmt::format("curve c{} d{}", i % 7, i / 7 % 4);
}

Markup legend(const LineChart& chart) {
  Markup list;
  list.open("ul", {{"class", "chart-legend"}});
  for (std::size_t i = 0; i < chart.lines.size(); ++i) {
    list.open("li").open("svg", {{"viewBox", "0 0 26 12"}, {"aria-hidden", "true"}});
    list.leaf("path", {{"class", curveClass(i)}, {"d", "M1 6L25 6"}}).close();
    list.text(shorten(chart.lines[i].name, 60)).close();
  }
  return list.close();
}

/// Where values lie: 0 at the foot, 1 at the top.
class ValueAxis {
 public:
  explicit ValueAxis(const LineChart& chart) : logarithmic_(chart.logarithmic) {
    double largest = 0, least = 0;
    for (const auto& line : chart.lines)
      for (const double y : line.y) {
        if (!std::isfinite(y) || y <= 0) continue;
        largest = std::max(largest, y);
        least = least > 0 ? std::min(least, y) : y;
      }
    if (!(largest > 0)) largest = least = 1;
    if (logarithmic_) {
      foot_ = std::max(least / 1.1, largest / 1e4);
      top_ = 1.1 * largest;
      const double decade = std::pow(10, std::floor(std::log10(foot_)));
      for (double power = decade; power <= top_; power *= 10)
        for (const double factor : {1.0, 2.0, 5.0})
          if (power * factor >= foot_ && power * factor <= top_) ticks_.push_back(power * factor);
    } else {
      const bool isCloseUp = chart.closeUp && largest > least;
      const double step = niceStep(isCloseUp ? largest - least : largest, 4);
      if (isCloseUp) foot_ = step * std::floor(least / step);
      top_ = foot_ + 1.03 * (largest - foot_);
      for (double y = foot_; y <= top_; y += step) ticks_.push_back(y);
    }
  }

  double at(double y) const {
    const double share = logarithmic_ ? std::log(std::max(y, foot_) / foot_) / std::log(top_ / foot_)
                                      : (y - foot_) / (top_ - foot_);
    return std::clamp(share, 0.0, 1.0);
  }
  const std::vector<double>& ticks() const { return ticks_; }

 private:
  bool logarithmic_;
  double foot_ = 0, top_ = 1;
  std::vector<double> ticks_;
};

/// Where a chart's points lie in the plot.
class Plot {
 public:
  explicit Plot(const LineChart& chart)
      : chart_(chart),
        values_(chart),
        first_(chart.x.empty() ? 0 : chart.x.front()),
        range_(chart.x.size() < 2 ? 1 : chart.x.back() - first_) {}

  double across(double x) const {
    if (!chart_.closeUp) return plotWidth * (x - first_) / range_;
    const auto position = std::lower_bound(chart_.x.begin(), chart_.x.end(), x) - chart_.x.begin();
    return plotWidth * static_cast<double>(position) /
           static_cast<double>(std::max<std::size_t>(chart_.x.size(), 2) - 1);
  }
  double down(double y) const { return plotHeight * (1 - values_.at(y)); }
  const std::vector<double>& ticksY() const { return values_.ticks(); }
  std::vector<double> ticksX() const {
    if (chart_.closeUp) return chart_.x;
    std::vector<double> ticks;
    const double step = niceStep(range_, 5);
    for (double x = std::ceil(first_ / step) * step; x <= first_ + range_; x += step) ticks.push_back(x);
    return ticks;
  }

 private:
  const LineChart& chart_;
  ValueAxis values_;
  double first_, range_;
};

void addCurve(const LineChart& chart, std::size_t i, const Plot& plot, Markup& figure) {
  const LineChart::Line& line = chart.lines[i];
  Path path;
  bool drawing = false;
  for (std::size_t p = 0; p < std::min(chart.x.size(), line.y.size()); ++p) {
    const double x = plot.across(chart.x[p]), y = line.y[p];
    if (std::isfinite(y)) drawing ? path.line(x, plot.down(y)) : path.move(x, plot.down(y));
    drawing = std::isfinite(y);
  }
  if (path.empty()) return;
  figure.open("path", {{"class", curveClass(i)}, {"d", path.str()}});
  figure.element("title", shorten(line.name, 60)).close();
  const auto marked = line.mark ? std::find(chart.x.begin(), chart.x.end(), *line.mark) : chart.x.end();
  if (marked == chart.x.end()) return;
  const double y = line.y[static_cast<std::size_t>(marked - chart.x.begin())];
  if (!std::isfinite(y)) return;
  Path dot;  // a line without length and with round ends stays round however the figure is stretched
  dot.move(plot.across(*marked), plot.down(y)).line(plot.across(*marked), plot.down(y));
  figure.leaf("path", {{"class", fmt::format("mark c{}", i % 7)}, {"d", dot.str()}});
}

}  // namespace

Markup section(const LineChart& chart) {
  const Plot plot(chart);
  Markup figure;
  figure.open("figure", {{"class", "chart"}}).element("h3", shorten(chart.title, 160)).add(legend(chart));
  figure.element("p", {{"class", "axis"}}, shorten(chart.yName, 80));
  figure.open("div", {{"class", "plot"}}).open("div", {{"class", "ticks-y"}, {"aria-hidden", "true"}});
  for (const double y : plot.ticksY())
    figure.element("span", {{"style", fmt::format("top:{}%", number(100 * plot.down(y) / plotHeight))}},
                   number(y, 6));
  figure.close();
  figure.open("svg",
              {{"viewBox", fmt::format("0 0 {} {}", plotWidth, plotHeight)},
               {"preserveAspectRatio", "none"},
               {"role", "img"},
               {"aria-label", fmt::format("{}: {} curves", shorten(chart.title, 160), chart.lines.size())}});
  for (const double y : plot.ticksY())
    figure.leaf("path",
                {{"class", "grid"}, {"d", Path().move(0, plot.down(y)).line(plotWidth, plot.down(y)).str()}});
  for (std::size_t i = chart.lines.size(); i-- > 0;) addCurve(chart, i, plot, figure);  // the best one on top
  figure.close().open("div", {{"class", "ticks-x"}, {"aria-hidden", "true"}});
  for (const double x : plot.ticksX())
    figure.element("span", {{"style", fmt::format("left:{}%", number(100 * plot.across(x) / plotWidth))}},
                   number(x, 6));
  figure.close().close();
  figure.element("p", {{"class", "axis under"}}, shorten(chart.xName, 80));
  if (!chart.caption.empty()) figure.element("figcaption", shorten(chart.caption, 600));
  return figure.close();
}

}  // namespace estancia
