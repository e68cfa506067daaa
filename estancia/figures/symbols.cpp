// SPDX-License-Identifier: Apache-2.0
#include "estancia/figures/symbols.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "estancia/figures/svg.hpp"

namespace estancia::report {

double textRoom(std::size_t shape) {
  constexpr std::array<double, 5> rooms{1.4, 1.4, 1.15, 1.4, 1.05};
  return rooms.at(shape);
}

double reachOf(std::size_t shape) {
  constexpr std::array<double, 5> reaches{1, 1, 1.26, 1.1, 1.3};
  return reaches.at(shape);
}

Markup symbol(const ClassStyle& style) {
  Markup icon;
  icon.open("svg", {{"class", "symbol"}, {"viewBox", "-10 -10 20 20"}, {"aria-hidden", "true"}});
  return icon.leaf("path", {{"d", shapePath(style.shape, 7)}, {"fill", style.fill.hex()}}).close();
}

Markup badge(const ClassStyle& style, const std::string& text) {
  Markup icon;
  icon.open("svg", {{"class", "badge"}, {"viewBox", "-20 -20 40 40"}, {"aria-hidden", "true"}});
  icon.leaf("path", {{"d", shapePath(style.shape, unitRadius)},
                     {"transform", fmt::format("scale({})", number(15 / unitRadius))},
                     {"fill", style.fill.hex()}});
  icon.element("text",
               {{"y", 4.5}, {"font-size", std::min(13.0, 22 / textWidth(text))}, {"fill", style.fill.ink()}},
               text);
  return icon.close();
}

}  // namespace estancia::report
