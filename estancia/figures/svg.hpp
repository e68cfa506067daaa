// SVG: points, boxes, paths and symbols of drawings.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <limits>

#include "estancia/figures/html.hpp"

namespace estancia::report {

struct Point {
  double x = 0, y = 0;
};

/// The least box around points.
struct Extent {
  Point low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  Point high{-low.x, -low.y};

  void add(const Point& p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  }
};

struct Box {
  double x = 0, y = 0, width = 0, height = 0;

  bool overlaps(const Box& other) const {
    return x < other.x + other.width && other.x < x + width && y < other.y + other.height &&
           other.y < y + height;
  }
  bool overlapsCircle(const Point& center, double radius) const;
  bool inside(const Box& outer) const {
    return x >= outer.x && y >= outer.y && x + width <= outer.x + outer.width &&
           y + height <= outer.y + outer.height;
  }
  /// Whether the line from a to b touches the box.
  bool crosses(const Point& a, const Point& b) const;
};

/// The `d` attribute of a path, one decimal.
class Path {
 public:
  Path& move(double x, double y) { return step('M', x, y); }
  Path& line(double x, double y) { return step('L', x, y); }
  Path& close() {
    d_ += 'Z';
    return *this;
  }
  const std::string& str() const { return d_; }
  bool empty() const { return d_.empty(); }

 private:
  Path& step(char command, double x, double y);
  std::string d_;
};

/// A symbol's outline around `center`, of the area of a circle with this radius; see ClassStyle::shape.
std::string shapePath(std::size_t shape, double radius, const Point& center = {});

/// A <text> of class `kind`; `anchor` is "start", "middle", "end", or "" for none.
void addText(Markup& svg, const char* kind, const Point& at, double size, std::string_view text,
             const std::string& anchor = "");

/// A step of 1, 2 or 5 · 10ⁿ between the ticks of an axis, so that about `count` steps reach `range` > 0.
double niceStep(double range, double count);

}  // namespace estancia::report
