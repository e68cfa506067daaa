// SPDX-License-Identifier: Apache-2.0
#include "objects/solids.hpp"

#include <algorithm>

namespace estancia::experiments {
namespace {

constexpr double infiniteDistance = HUGE_VAL;

/// A ray in the frame of a solid's middle, and where it enters and leaves the solid.
struct Crossing {
  cv::Vec3d from, ray;
  double in = -infiniteDistance, out = infiniteDistance;
  cv::Vec3d normal = {};

  void slab(int k, double half) {
    double a = (-half - from[k]) / ray[k], b = (half - from[k]) / ray[k];
    if (a > b) std::swap(a, b);
    if (a > in) {
      in = a;
      normal = {};
      normal[k] = ray[k] > 0 ? -1 : 1;
    }
    out = std::min(out, b);
  }
  /// Round in the first `axes` axes. Whether it is crossed.
  bool round(int axes, const cv::Vec3d& half) {
    double a = 0, b = 0, c = -1;
    for (int k = 0; k < axes; ++k) {
      const double r = ray[k] / half[k], o = from[k] / half[k];
      a += r * r;
      b += o * r;
      c += o * o;
    }
    if (a == 0) return c <= 0;  // along the upright
    const double inside = b * b - a * c;
    if (inside < 0) return false;
    const double enter = (-b - std::sqrt(inside)) / a;
    if (enter > in) {
      in = enter;
      normal = {};
      for (int k = 0; k < axes; ++k) normal[k] = (from[k] + enter * ray[k]) / (half[k] * half[k]);
      normal = cv::normalize(normal);
    }
    out = std::min(out, (-b + std::sqrt(inside)) / a);
    return true;
  }
};

}  // namespace

bool cast(const Solid& solid, const cv::Vec3d& from, const cv::Vec3d& ray, SolidHit& nearest) {
  const double c = std::cos(solid.angle), s = std::sin(solid.angle);
  const cv::Vec3d half = solid.size / 2, d = from - (solid.at + cv::Vec3d(0, 0, half[2]));
  Crossing crossing{{c * d[0] + s * d[1], -s * d[0] + c * d[1], d[2]},
                    {c * ray[0] + s * ray[1], -s * ray[0] + c * ray[1], ray[2]}};
  if (solid.shape == Solid::Shape::ellipsoid) {
    if (!crossing.round(3, half)) return false;
  } else {
    crossing.slab(2, half[2]);
    if (solid.shape == Solid::Shape::cylinder) {
      if (!crossing.round(2, half)) return false;
    } else {
      crossing.slab(0, half[0]);
      crossing.slab(1, half[1]);
    }
  }
  if (!(crossing.in > 0 && crossing.in <= crossing.out && crossing.in < nearest.t)) return false;
  const cv::Vec3d p = crossing.from + crossing.in * crossing.ray, n = crossing.normal;
  nearest = {crossing.in,
             {c * n[0] - s * n[1], s * n[0] + c * n[1], n[2]},
             {p[0] / half[0], p[1] / half[1], p[2] / half[2]}};
  return true;
}

std::vector<cv::Point3f> surfaceOf(std::span<const Solid> solids, double step) {
  cv::Vec3d low(infiniteDistance, infiniteDistance, infiniteDistance), high = -low;
  for (const Solid& solid : solids) {
    const double reach = std::hypot(solid.size[0], solid.size[1]) / 2;
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], solid.at[k] - (k < 2 ? reach : 0));
      high[k] = std::max(high[k], solid.at[k] + (k < 2 ? reach : solid.size[2]));
    }
  }
  std::vector<cv::Point3f> points;
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {-1., 1.}) {
      const int a = (axis + 1) % 3, b = (axis + 2) % 3;
      cv::Vec3d ray, from;
      ray[axis] = sign;
      from[axis] = sign > 0 ? low[axis] - 1 : high[axis] + 1;
      for (from[a] = low[a] + step / 2; from[a] < high[a]; from[a] += step)
        for (from[b] = low[b] + step / 2; from[b] < high[b]; from[b] += step) {
          SolidHit hit;
          for (const Solid& solid : solids) cast(solid, from, ray, hit);
          // What is seen at a slant is that of another view.
          if (std::isfinite(hit.t) && std::abs(hit.normal[axis]) > 0.577)
            points.push_back(cv::Vec3f(from + hit.t * ray));
        }
    }
  return points;
}

}  // namespace estancia::experiments
