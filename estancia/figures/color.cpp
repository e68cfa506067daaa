// SPDX-License-Identifier: Apache-2.0
#include "estancia/figures/color.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "estancia/figures/svg.hpp"

namespace estancia::report {
namespace {

Color mix(const Color& a, const Color& b, double t) {
  const auto channel = [t](int from, int to) {
    return static_cast<int>(std::lround(from + t * (to - from)));
  };
  return {channel(a.red, b.red), channel(a.green, b.green), channel(a.blue, b.blue)};
}

double luminance(const Color& color) {
  const auto linear = [](int channel) {
    const double c = channel / 255.0;
    return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
  };
  return 0.2126 * linear(color.red) + 0.7152 * linear(color.green) + 0.0722 * linear(color.blue);
}

constexpr std::array<Color, 7> hues{{{0x00, 0x72, 0xb2},
                                     {0xe6, 0x9f, 0x00},
                                     {0x00, 0x9e, 0x73},
                                     {0xcc, 0x79, 0xa7},
                                     {0x56, 0xb4, 0xe9},
                                     {0xd5, 0x5e, 0x00},
                                     {0xf0, 0xe4, 0x42}}};
constexpr std::size_t shapes = 5;

ClassStyle styleOf(std::size_t hue, std::size_t shape, std::size_t tone) {
  constexpr std::array<Color, 3> towards{{{0, 0, 0}, {255, 255, 255}, {0, 0, 0}}};
  static_assert(hues.size() * shapes * towards.size() == distinctClasses);
  tone %= towards.size();
  return {mix(hues[hue % hues.size()], towards[tone], tone == 0 ? 0 : 0.45), shape % shapes};
}

}  // namespace

std::string Color::hex() const {
  return fmt::format("#{:02x}{:02x}{:02x}", red, green, blue);
}

std::string Color::ink() const {
  // equal contrast against black and white: (L + .05)² = .05 · 1.05
  return luminance(*this) > 0.179 ? "#000" : "#fff";
}

const std::vector<Color>& viridisStops() {
  static const std::vector<Color> stops{{0x44, 0x01, 0x54}, {0x48, 0x24, 0x75}, {0x41, 0x44, 0x87},
                                        {0x35, 0x5f, 0x8d}, {0x2a, 0x78, 0x8e}, {0x21, 0x91, 0x8c},
                                        {0x22, 0xa8, 0x84}, {0x44, 0xbf, 0x70}, {0x7a, 0xd1, 0x51},
                                        {0xbd, 0xdf, 0x26}, {0xfd, 0xe7, 0x25}};
  return stops;
}

Color viridis(double t) {
  const auto& stops = viridisStops();
  const double place = (t > 0 ? std::min(t, 1.0) : 0) * static_cast<double>(stops.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(place), stops.size() - 2);
  return mix(stops[below], stops[below + 1], place - static_cast<double>(below));
}

ClassStyle classStyle(std::size_t i) {
  return styleOf(i, i / hues.size(), i / (hues.size() * shapes));
}

ClassStyle symbolStyle(std::size_t i) {
  return styleOf(i, i, i / (hues.size() * shapes));  // 7 and 5 have no common divisor
}

ClassStyle plainStyle() {
  return {{0x8a, 0x93, 0x9e}, 0};
}

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

Markup bar(double percent, const Color* fill) {
  const std::string color = fill == nullptr ? "" : ";background:" + fill->hex();
  Markup span;
  span.open("span", {{"class", "bar"}});
  return span.element("i", {{"style", fmt::format("width:{}%{}", number(percent, 1), color)}}, "").close();
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
