// Class styles: the colors and symbols of rooms and zones, which people with color-blindness can distinguish.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estancia/figures/html.hpp"

namespace estancia::report {

struct Color {
  int red = 0, green = 0, blue = 0;  ///< sRGB, 0 … 255

  std::string hex() const;  ///< "#rrggbb"
  /// Black or white, whichever reads better on this color (WCAG relative luminance).
  std::string ink() const;
};

/// Eleven evenly spaced colors of viridis (Smith & van der Walt, matplotlib), perceptually uniform.
const std::vector<Color>& viridisStops();

/// viridis between its stops; t is clamped to [0, 1].
Color viridis(double t);

struct ClassStyle {
  Color fill;
  std::size_t shape = 0;  ///< 0 circle, 1 square, 2 diamond, 3 hexagon, 4 triangle
};

/// Number of classes that differ from each other in hue, shape or lightness.
constexpr std::size_t distinctClasses = 105;

/// How the i-th of many classes is drawn: hues first (Okabe & Ito's seven), then shapes, then lightness.
ClassStyle classStyle(std::size_t i);

/// Style of symbols too small to hold a name: hue and shape change together, so that the first five differ in
/// shape alone, and the first 35 in hue or shape.
ClassStyle symbolStyle(std::size_t i);

/// Mark of everything without a class of its own: a gray disc.
ClassStyle plainStyle();

/// Symbols that a page's script repaints are drawn with this radius, and scaled.
constexpr double unitRadius = 10;

/// Width for a text inside a symbol, in radii.
double textRoom(std::size_t shape);

/// How far a symbol reaches from its middle, in radii.
double reachOf(std::size_t shape);

/// An <svg> of the symbol, hidden from screen readers: the name stands beside it.
Markup symbol(const ClassStyle& style);

/// A <span> "bar" that is filled to so many percent, in a color of its own where `fill` is one.
Markup bar(double percent, const Color* fill = nullptr);

/// An <svg> of the symbol with a short text inside.
Markup badge(const ClassStyle& style, const std::string& text);

}  // namespace estancia::report
