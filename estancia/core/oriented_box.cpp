// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/oriented_box.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "estancia/core/fail.hpp"

namespace estancia {
namespace {

/// Corners on the floor relative to `origin`, counter-clockwise.
std::vector<cv::Point2d> footprint(const OrientedBox& box, const cv::Point3d& origin) {
  const double c = std::cos(box.yaw), s = std::sin(box.yaw);
  std::vector<cv::Point2d> corners;
  for (const auto& [along, across] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
    const double u = along * box.size.x / 2, v = across * box.size.y / 2;
    corners.emplace_back(box.center.x - origin.x + c * u - s * v, box.center.y - origin.y + s * u + c * v);
  }
  return corners;
}

/// Area of the intersection of two convex polygons (Sutherland and Hodgman 1974). OpenCV's
/// intersectConvexConvex() loses it where edges lie on one line.
double commonArea(std::vector<cv::Point2d> polygon, const std::vector<cv::Point2d>& clip) {
  for (std::size_t e = 0; e < clip.size(); ++e) {
    const cv::Point2d from = clip[e], along = clip[(e + 1) % clip.size()] - from;
    std::vector<cv::Point2d> inside;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const cv::Point2d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
      const double left = along.cross(a - from), next = along.cross(b - from);
      if (left >= 0) inside.push_back(a);
      if ((left < 0) != (next < 0)) inside.push_back(a + (b - a) * (left / (left - next)));
    }
    polygon = std::move(inside);
  }
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i)
    twice += polygon[i].cross(polygon[(i + 1) % polygon.size()]);
  return std::max(0.0, twice / 2);
}

struct Extent {
  double low = 0, high = 0;
  double length() const { return high - low; }
  double middle() const { return (low + high) / 2; }
};

/// Without the outermost `out` values at each end; reorders them.
Extent extentOf(std::vector<double>& values, std::size_t out) {
  const auto low = values.begin() + static_cast<std::ptrdiff_t>(out);
  const auto high = values.end() - 1 - static_cast<std::ptrdiff_t>(out);
  std::nth_element(values.begin(), low, values.end());
  const double least = *low;
  std::nth_element(values.begin(), high, values.end());
  return {least, *high};
}

}  // namespace

double intersectionOverUnion(const OrientedBox& a, const OrientedBox& b) {
  const double height = std::min(a.center.z + a.size.z / 2, b.center.z + b.size.z / 2) -
                        std::max(a.center.z - a.size.z / 2, b.center.z - b.size.z / 2);
  const double reach = (std::hypot(a.size.x, a.size.y) + std::hypot(b.size.x, b.size.y)) / 2;
  if (!std::isfinite(a.yaw) || !std::isfinite(b.yaw)) return 0;
  if (!(height > 0) || !(a.volume() > 0) || !(b.volume() > 0) ||
      !(std::hypot(a.center.x - b.center.x, a.center.y - b.center.y) < reach))
    return 0;
  const double both = height * commonArea(footprint(a, a.center), footprint(b, a.center));
  return both / (a.volume() + b.volume() - both);
}

OrientedBox fitBox(std::span<const cv::Point3d> points, double trim, double thickness) {
  if (points.empty()) fail(ErrorCode::invalidInput, "a box needs points");
  constexpr int step = 2;  // [degrees]
  const std::size_t out =
      std::min(static_cast<std::size_t>(trim * static_cast<double>(points.size())), (points.size() - 1) / 2);
  std::vector<double> along(points.size()), across(points.size());
  OrientedBox box;
  double least = std::numeric_limits<double>::infinity();
  for (int degrees = 0; degrees < 90; degrees += step) {
    const double yaw = degrees * std::numbers::pi / 180, c = std::cos(yaw), s = std::sin(yaw);
    for (std::size_t i = 0; i < points.size(); ++i) {
      along[i] = c * points[i].x + s * points[i].y;
      across[i] = -s * points[i].x + c * points[i].y;
    }
    const Extent u = extentOf(along, out), v = extentOf(across, out);
    const double area = std::max(u.length(), thickness) * std::max(v.length(), thickness);
    if (area >= least) continue;
    least = area;
    box.center = {c * u.middle() - s * v.middle(), s * u.middle() + c * v.middle(), 0};
    box.size = {std::max(u.length(), thickness), std::max(v.length(), thickness), 0};
    box.yaw = yaw;
  }
  for (std::size_t i = 0; i < points.size(); ++i) along[i] = points[i].z;
  const Extent z = extentOf(along, out);
  box.center.z = z.middle();
  box.size.z = std::max(z.length(), thickness);
  return box;
}

}  // namespace estancia
