// SPDX-License-Identifier: Apache-2.0
#include "estancia/figures/svg.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace estancia::report {

bool Box::overlapsCircle(const Point& center, double radius) const {
  const double dx = center.x - std::clamp(center.x, x, x + width);
  const double dy = center.y - std::clamp(center.y, y, y + height);
  return dx * dx + dy * dy < radius * radius;
}

bool Box::crosses(const Point& a, const Point& b) const {
  // Liang–Barsky: the part of a + t (b − a), t in [0, 1], that lies between the box's sides
  double from = 0, to = 1;
  const auto clip = [&](double start, double delta, double low, double high) {
    if (delta == 0) return start >= low && start <= high;
    const double first = (low - start) / delta, second = (high - start) / delta;
    from = std::max(from, std::min(first, second));
    to = std::min(to, std::max(first, second));
    return from <= to;
  };
  return clip(a.x, b.x - a.x, x, x + width) && clip(a.y, b.y - a.y, y, y + height);
}

Path& Path::step(char command, double x, double y) {
  d_ += fmt::format("{}{} {}", command, number(x, 1), number(y, 1));
  return *this;
}

std::string shapePath(std::size_t shape, double radius, const Point& center) {
  using std::numbers::pi;
  if (shape == 0)
    return fmt::format("M{2} {3}a{0} {0} 0 1 0 {1} 0a{0} {0} 0 1 0 -{1} 0Z", number(radius),
                       number(2 * radius), number(center.x - radius), number(center.y));
  const int corners = shape == 3 ? 6 : shape == 4 ? 3 : 4;
  const double start =
      shape == 1 ? pi / 4 : pi / 2;  // a square lies on its side, the others stand on a corner
  // a regular polygon of n corners on a circle of radius c has the area n/2 c² sin(2π/n)
  const double corner = radius * std::sqrt(2 * pi / (corners * std::sin(2 * pi / corners)));
  Path path;
  for (int i = 0; i < corners; ++i) {
    const double angle = start + 2 * pi * i / corners;
    const double x = center.x + corner * std::cos(angle), y = center.y - corner * std::sin(angle);
    i == 0 ? path.move(x, y) : path.line(x, y);
  }
  return path.close().str();
}

void addText(Markup& svg, const char* kind, const Point& at, double size, std::string_view text,
             const std::string& anchor) {
  Attributes attributes{{"class", kind}, {"x", at.x}, {"y", at.y}};
  if (!anchor.empty()) attributes.push_back({"text-anchor", anchor});
  attributes.push_back({"font-size", size});
  svg.element("text", attributes, text);
}

double niceStep(double range, double count) {
  const double raw = range / count, power = std::pow(10, std::floor(std::log10(raw)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (raw <= factor * power * 1.0000001) return factor * power;
  return 10 * power;
}

}  // namespace estancia::report
