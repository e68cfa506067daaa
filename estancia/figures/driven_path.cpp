// SPDX-License-Identifier: Apache-2.0
#include "estancia/figures/driven_path.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace estancia::report {

Markup openFigure(const char* kind, const FigureStyle& style, const std::string& label) {
  Markup svg;
  svg.open("svg", {{"class", fmt::format("{} {}", kind, style.name)},
                   {"viewBox", fmt::format("0 0 {} {}", number(style.width), number(style.height))},
                   {"role", "group"},
                   {"aria-label", label}});
  return svg;
}

double neededHeight(const Fit& fit, const std::vector<Point>& extent, const FigureStyle& style,
                    double borders) {
  Extent drawn{fit.to, fit.to};
  for (const Point& p : extent) drawn.add(fit(p));
  return std::clamp(std::ceil(drawn.high.y - drawn.low.y + borders), 0.55 * style.width, style.height);
}

void drawPath(Markup& svg, const std::vector<std::optional<Point>>& points, const Fit& fit,
              std::span<const std::size_t> starts) {
  constexpr double step = 1.5;
  Path path;
  std::optional<Point> last;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i] || std::ranges::binary_search(starts, i)) last.reset();
    if (!points[i]) continue;
    const Point p = fit(*points[i]);
    if (last && std::hypot(p.x - last->x, p.y - last->y) < step) continue;
    last ? path.line(p.x, p.y) : path.move(p.x, p.y);
    last = p;
  }
  if (!path.empty()) svg.leaf("path", {{"class", "driven"}, {"d", path.str()}});
}

Box drawScale(Markup& svg, double scale, const FigureStyle& style) {
  if (!(scale > 0)) return {};
  const double most = 0.2 * style.width / scale;
  const double power = std::pow(10, std::floor(std::log10(most)));
  const double meters = 5 * power <= most ? 5 * power : 2 * power <= most ? 2 * power : power;
  const double x = figureMargin, y = style.height - figureMargin, length = meters * scale;
  svg.leaf("path",
           {{"class", "scale"},
            {"d", Path().move(x, y - 5).line(x, y).line(x + length, y).line(x + length, y - 5).str()}});
  addText(svg, "scale-text", {x + 6, y - 6}, style.fontSize, significant(meters) + " m");
  return {x, y - 8 - style.fontSize, std::max(length, 50.0), 8 + style.fontSize};
}

}  // namespace estancia::report
