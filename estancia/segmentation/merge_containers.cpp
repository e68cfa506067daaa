// SPDX-License-Identifier: Apache-2.0
#include "estancia/segmentation/segmentation_stages.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <optional>
#include <tuple>

namespace estancia {
namespace {

/// A circle through most of the points of a plane.
struct Circle {
  cv::Point2d center;
  double radius = 0;
  double share = 0;  ///< share of the points that lie on it
  double arc = 0;    ///< angle that they cover [°]
};

double quantile(std::vector<double> values, double share) {
  const auto rank = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::ranges::nth_element(values, values.begin() + rank);
  return values[static_cast<std::size_t>(rank)];
}

/// Trimmed least squares (Kåsa 1976).
std::optional<Circle> fitCircle(const std::vector<cv::Point2d>& points, double tolerance) {
  constexpr double trimmed = 0.7, minLimit = 0.75;  // quantile of the points; share of the tolerance
  Circle circle;
  std::vector<double> off(points.size(), 0);
  double limit = 0;
  for (int round = 0; round < 6; ++round) {
    cv::Matx33d squares = cv::Matx33d::zeros();
    cv::Vec3d products, x;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (off[i] > limit) continue;
      const cv::Vec3d row(points[i].x, points[i].y, 1);
      squares += row * row.t();
      products += row * points[i].dot(points[i]);
    }
    if (!cv::solve(squares, products, x, cv::DECOMP_CHOLESKY)) return {};
    circle.center = {x[0] / 2, x[1] / 2};
    circle.radius = std::sqrt(std::max(1e-9, x[2] + circle.center.dot(circle.center)));
    for (std::size_t i = 0; i < points.size(); ++i)
      off[i] = std::abs(cv::norm(points[i] - circle.center) - circle.radius);
    limit = std::max(minLimit * tolerance, quantile(off, trimmed));
  }
  std::vector<double> angles;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const cv::Point2d d = points[i] - circle.center;
    if (off[i] < tolerance) angles.push_back(std::atan2(d.y, d.x));
  }
  if (angles.empty()) return {};
  circle.share = static_cast<double>(angles.size()) / static_cast<double>(points.size());
  std::ranges::sort(angles);
  double gap = angles.front() + 2 * CV_PI - angles.back();
  for (std::size_t i = 1; i < angles.size(); ++i) gap = std::max(gap, angles[i] - angles[i - 1]);
  circle.arc = 360 - gap * 180 / CV_PI;
  return circle;
}

/// A segment in the coordinates of the plane below it.
struct Footprint {
  std::vector<cv::Point2d> points;
  std::vector<double> heights;
};

/// Coordinates on a plane, and heights above it.
class Ground {
 public:
  explicit Ground(const Plane& plane) : n_(plane.normal), offset_(plane.offset) {
    const cv::Vec3d side = std::abs(n_[0]) < 0.9 ? cv::Vec3d(1, 0, 0) : cv::Vec3d(0, 1, 0);
    e1_ = cv::normalize(n_.cross(side));
    e2_ = n_.cross(e1_);
  }
  cv::Point2d foot(const cv::Vec3d& p) const { return {p.dot(e1_), p.dot(e2_)}; }
  double height(const cv::Vec3d& p) const { return p.dot(n_) - offset_; }

 private:
  cv::Vec3d n_, e1_, e2_;
  double offset_;
};

Footprint footprintOf(const SegmentSamples& segment, const Plane& plane, std::size_t step) {
  const Ground ground(plane);
  Footprint result;
  for (std::size_t i = 0; i < segment.surface.size(); i += step) {
    const cv::Vec3d p(segment.surface[i].x, segment.surface[i].y, segment.surface[i].z);
    result.points.push_back(ground.foot(p));
    result.heights.push_back(ground.height(p));
  }
  return result;
}

constexpr std::size_t pointStep = 5;  // every fifth point of a surface is enough for its footprint

/// The supporting plane: the nearest one below the segment.
const Plane* supportOf(const SegmentSamples& segment, const std::vector<Plane>& planes) {
  const Plane* support = nullptr;
  double lowest = HUGE_VAL;
  for (const Plane& plane : planes) {
    const double height = quantile(footprintOf(segment, plane, pointStep).heights, 0.05);
    if (height > -0.02 && height < lowest) std::tie(lowest, support) = std::tuple(height, &plane);
  }
  return support;
}

/// The circle of a round wall, or of its rim where the wall is inclined.
std::optional<Circle> wallOf(const Footprint& segment, double rim) {
  constexpr double tolerance = 0.008, belowRim = 0.02;  // [m]
  constexpr double minRadius = 0.02, maxRadius = 0.20;  // radius [m]
  constexpr double minShare = 0.6, minArc = 90;
  constexpr std::size_t minPoints = 30, maxUpper = 300;
  std::vector<cv::Point2d> all, upper;
  std::size_t above = 0;
  for (const double height : segment.heights) above += height > rim - belowRim ? 1 : 0;
  const std::size_t every = 1 + above / maxUpper;
  for (std::size_t i = 0; i < segment.points.size(); ++i) {
    if (i % pointStep == 0) all.push_back(segment.points[i]);
    if (segment.heights[i] > rim - belowRim && above-- % every == 0) upper.push_back(segment.points[i]);
  }
  for (const auto* points : {&all, &upper}) {
    if (points->size() < minPoints) continue;
    const auto circle = fitCircle(*points, tolerance);
    if (circle && circle->radius >= minRadius && circle->radius <= maxRadius && circle->share > minShare &&
        circle->arc > minArc)
      return circle;
  }
  return {};
}

/// Whether most of a segment lies within a circle, below a rim, and above the foot of the wall: what a wall
/// stands on may be as round (a can on a can).
bool isInside(const SegmentSamples& segment, const Plane& plane, const Circle& circle, double foot,
              double rim) {
  constexpr double beside = 0.015;  // [m]
  constexpr double inside = 0.85;
  const Ground ground(plane);
  const std::size_t count = (segment.surface.size() + pointStep - 1) / pointStep;
  std::size_t in = 0, seen = 0;
  for (std::size_t i = 0; i < segment.surface.size(); i += pointStep) {
    const cv::Vec3d p(segment.surface[i].x, segment.surface[i].y, segment.surface[i].z);
    const double height = ground.height(p);
    in += cv::norm(ground.foot(p) - circle.center) < circle.radius + beside && height < rim + beside &&
          height > foot - beside;
    const std::size_t out = ++seen - in;  // most segments are elsewhere: a few points decide early
    if (!(static_cast<double>(count - out) > inside * static_cast<double>(count))) return false;
  }
  return true;
}

}  // namespace

void mergeContainerInteriors(const InverseDepth& grid, const Mask& mask, const std::vector<Plane>& planes,
                             int threads, Segmentation& segments) {
  if (planes.empty()) return;
  const std::vector<SegmentSamples> samples = sampleSegments(grid, mask, segments);
  const auto find = [&](std::size_t index) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> result;
    const SegmentSamples& wall = samples[index];
    if (segments.sizes[wall.segment] < grid.area(600) || cv::norm(wall.box.high - wall.box.low) > 0.8)  // [m]
      return result;
    const Plane* support = supportOf(wall, planes);
    if (support == nullptr) return result;
    const Footprint footprint = footprintOf(wall, *support, 1);
    const double rim = quantile(footprint.heights, 0.98);
    const double foot = quantile(footprint.heights, 0.02);
    const auto circle = wallOf(footprint, rim);
    if (!circle) return result;
    for (const SegmentSamples& other : samples) {
      if (&other == &wall || segments.sizes[other.segment] > 3 * segments.sizes[wall.segment]) continue;
      if (isInside(other, *support, *circle, foot, rim)) result.emplace_back(wall.segment, other.segment);
    }
    return result;
  };
  mergePairs(samples.size(), find, mask, threads, segments);
}

}  // namespace estancia
