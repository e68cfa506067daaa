// Bounding box: the axis-aligned box around points.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <limits>
#include <span>

#include "estancia/core/point_cloud.hpp"

namespace estancia {

template <class Number>
struct Bounds {
  using Point = cv::Point3_<Number>;
  static constexpr Number infinity = std::numeric_limits<Number>::infinity();
  Point low{infinity, infinity, infinity}, high{-infinity, -infinity, -infinity};

  void add(const Point& p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  bool empty() const { return !(low.x <= high.x); }
  bool contains(const Point& p) const {
    return p.x >= low.x && p.y >= low.y && p.z >= low.z && p.x <= high.x && p.y <= high.y && p.z <= high.z;
  }
};

/// Bounding box of the finite points.
inline Bounds<float> boundsOf(std::span<const cv::Point3f> points) {
  Bounds<float> box;
  for (const cv::Point3f& p : points)
    if (isFinite(p)) box.add(p);
  return box;
}

}  // namespace estancia
