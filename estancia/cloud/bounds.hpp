// Bounding box: the axis-aligned box around points.
#pragma once

#include <algorithm>
#include <limits>
#include <opencv2/core/types.hpp>

namespace estancia {

/// Without points, `low` is above `high`.
template <class Number>
struct Bounds {
  using Point = cv::Point3_<Number>;
  static constexpr Number infinity = std::numeric_limits<Number>::infinity();
  Point low{infinity, infinity, infinity}, high{-infinity, -infinity, -infinity};

  void add(const Point& p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  bool contains(const Point& p) const {
    return p.x >= low.x && p.y >= low.y && p.z >= low.z && p.x <= high.x && p.y <= high.y && p.z <= high.z;
  }
};

}  // namespace estancia
