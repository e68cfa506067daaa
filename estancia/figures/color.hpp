// Color palettes: colors that people with color-blindness can distinguish.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

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

}  // namespace estancia::report
