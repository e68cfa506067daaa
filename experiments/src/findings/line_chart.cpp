#include "experiments/src/findings/line_chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "estancia/report/svg.hpp"

namespace estancia::experiments {

using namespace report;
namespace {

constexpr double plotWidth = 1000, plotHeight = 280;  // the browser stretches them to its width

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
      const double step = niceStep(chart.closeUp && largest > least ? largest - least : largest, 4);
      if (chart.closeUp) foot_ = step * std::floor(least / step);
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

}  // namespace

std::string curveClass(std::size_t i) {
  return fmt::format("curve c{} d{}", i % 7, i / 7 % 4);
}

Markup lineChart(const LineChart& chart) {
  const ValueAxis values(chart);
  const double first = chart.x.empty() ? 0 : chart.x.front();
  const double range = chart.x.size() < 2 ? 1 : chart.x.back() - first;
  const auto across = [&](double x) {
    if (!chart.closeUp) return plotWidth * (x - first) / range;
    const auto position = std::lower_bound(chart.x.begin(), chart.x.end(), x) - chart.x.begin();
    return plotWidth * static_cast<double>(position) /
           static_cast<double>(std::max<std::size_t>(chart.x.size(), 2) - 1);
  };
  const auto down = [&](double y) { return plotHeight * (1 - values.at(y)); };

  Markup figure;
  figure.open("figure", {{"class", "chart"}}).element("h3", shorten(chart.title, 160)).add(legend(chart));
  figure.element("p", {{"class", "axis"}}, shorten(chart.yName, 80));
  figure.open("div", {{"class", "plot"}}).open("div", {{"class", "ticks-y"}, {"aria-hidden", "true"}});
  const double xStep = niceStep(range, 5);
  for (const double y : values.ticks())
    figure.element("span", {{"style", fmt::format("top:{}%", number(100 * down(y) / plotHeight))}},
                   number(y, 6));
  figure.close();
  figure.open("svg",
              {{"viewBox", fmt::format("0 0 {} {}", plotWidth, plotHeight)},
               {"preserveAspectRatio", "none"},
               {"role", "img"},
               {"aria-label", fmt::format("{}: {} curves", shorten(chart.title, 160), chart.lines.size())}});
  for (const double y : values.ticks())
    figure.leaf("path", {{"class", "grid"}, {"d", Path().move(0, down(y)).line(plotWidth, down(y)).str()}});
  for (std::size_t i = chart.lines.size(); i-- > 0;) {  // the first one, the best, lies on top
    Path path;
    bool drawing = false;
    for (std::size_t p = 0; p < std::min(chart.x.size(), chart.lines[i].y.size()); ++p) {
      const double y = chart.lines[i].y[p];
      if (std::isfinite(y))
        drawing ? path.line(across(chart.x[p]), down(y)) : path.move(across(chart.x[p]), down(y));
      drawing = std::isfinite(y);
    }
    if (path.empty()) continue;
    figure.open("path", {{"class", curveClass(i)}, {"d", path.str()}});
    figure.element("title", shorten(chart.lines[i].name, 60)).close();
    const auto marked =
        chart.lines[i].mark ? std::find(chart.x.begin(), chart.x.end(), *chart.lines[i].mark) : chart.x.end();
    if (marked == chart.x.end()) continue;
    const double y = chart.lines[i].y[static_cast<std::size_t>(marked - chart.x.begin())];
    if (!std::isfinite(y)) continue;
    Path dot;  // a line without length and with round ends stays round however the figure is stretched
    dot.move(across(*marked), down(y)).line(across(*marked), down(y));
    figure.leaf("path", {{"class", fmt::format("mark c{}", i % 7)}, {"d", dot.str()}});
  }
  figure.close().open("div", {{"class", "ticks-x"}, {"aria-hidden", "true"}});
  std::vector<double> named;
  if (chart.closeUp) named = chart.x;
  if (!chart.closeUp)
    for (double x = std::ceil(first / xStep) * xStep; x <= first + range; x += xStep) named.push_back(x);
  for (const double x : named)
    figure.element("span", {{"style", fmt::format("left:{}%", number(100 * across(x) / plotWidth))}},
                   number(x, 6));
  figure.close().close();
  figure.element("p", {{"class", "axis under"}}, shorten(chart.xName, 80));
  if (!chart.caption.empty()) figure.element("figcaption", shorten(chart.caption, 600));
  return figure.close();
}

}  // namespace estancia::experiments
