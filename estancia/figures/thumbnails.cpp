// SPDX-License-Identifier: Apache-2.0
#include "estancia/figures/thumbnails.hpp"

#include <algorithm>
#include <array>

namespace estancia::report {

bool Thumbnails::isFree(const Box& box) const {
  return box.inside(frame_) &&
         std::ranges::none_of(taken_, [&box](const Box& other) { return other.overlaps(box); });
}

std::optional<Box> Thumbnails::take(const Point& at) {
  constexpr double gap = 2;
  constexpr std::array<Point, 9> sides{
      {{0, 0}, {0, -1}, {1, 0}, {-1, 0}, {0, 1}, {1, -1}, {-1, -1}, {1, 1}, {-1, 1}}};
  for (const double size : {size_, 0.72 * size_})
    for (const Point& side : sides) {
      // Beside its point the image leaves it to be seen.
      const double away = size / 2 + 6;
      const Point middle{at.x + away * side.x, at.y + away * side.y};
      const Box box{middle.x - size / 2, middle.y - size / 2, size, size};
      if (!isFree({box.x - gap, box.y - gap, size + 2 * gap, size + 2 * gap})) continue;
      taken_.push_back(box);
      return box;
    }
  return std::nullopt;
}

}  // namespace estancia::report
