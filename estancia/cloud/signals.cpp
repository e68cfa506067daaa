// SPDX-License-Identifier: Apache-2.0
#include "estancia/cloud/signals.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/core.hpp>

#include "estancia/cloud/bounds.hpp"
#include "estancia/cloud/color_lab.hpp"
#include "estancia/cloud/neighbors.hpp"
#include "estancia/cloud/resolution.hpp"
#include "estancia/core/fail.hpp"

namespace estancia {
namespace {

bool same(const Point4& a, const Point4& b) {
  return a.x == b.x && a.y == b.y && a.z == b.z;
}

std::uint64_t hash(const Point4& p) {
  std::uint64_t h = 0;
  for (const float v : {p.x, p.y, p.z}) {
    h = (h ^ std::bit_cast<std::uint32_t>(v + 0.0F)) * 0x9e3779b97f4a7c15ULL;  // -0 is 0
    h ^= h >> 29;
  }
  return h;
}

/// The standard deviation of each channel's noise [units of CIELAB]: from the differences between about 2,000
/// points and their nearest, whose median ignores texture and edges. At least the rounding of 8 bits.
/// `points` are those of the colors, one each.
double estimateColorNoise(const Neighbors& points, const std::vector<cv::Vec3f>& lab) {
  constexpr std::size_t samples = 2000;
  constexpr double rounding = 100.0 / 255 / (2 * std::numbers::sqrt3);  // rounding to one of 255 levels of L*
  constexpr double chi3 = 1.5382;                                       // median of the norm of three normals
  std::vector<double> differences;
  std::vector<Neighbor> buffer;
  const std::size_t step = std::max<std::size_t>(points.size() / samples, 1);
  for (std::size_t i = 0; i < points.size(); i += step) {
    const std::uint32_t self = points.order()[i];
    for (const Neighbor& n : points.nearest(points.place(i), 2, buffer)) {
      if (n.index == self) continue;
      differences.push_back(cv::norm(lab[self] - lab[n.index]));
      break;
    }
  }
  if (differences.empty()) return rounding;
  const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
  std::nth_element(differences.begin(), middle, differences.end());
  return std::max(*middle / (std::numbers::sqrt2 * chi3), rounding);
}

}  // namespace

Signals::Signals(const PointCloud& cloud, std::uint64_t seed, double colorWeight) : seed_(seed) {
  const Bounds<float> box = boundsOf(cloud.points);
  const auto count = static_cast<std::size_t>(std::ranges::count_if(cloud.points, isFinite));
  if (count == 0)
    fail(ErrorCode::invalidInput, "none of the cloud's {} points is finite; a neural gas needs at least one",
         cloud.points.size());
  if (count > std::numeric_limits<std::uint32_t>::max())
    fail(ErrorCode::tooLarge, "the cloud has {} points, a neural gas takes at most {}; thin it out first",
         count, std::numeric_limits<std::uint32_t>::max());
  middle_ = (cv::Point3d(box.low) + cv::Point3d(box.high)) / 2;
  const cv::Point3d half = cv::Point3d(box.high) - middle_;
  const double extent = std::max({half.x, half.y, half.z});
  int exponent = 0;
  std::frexp(extent, &exponent);
  scale_ = extent > 0 ? std::ldexp(1.0, -exponent) : 1.0;
  points_.reserve(count);
  for (const cv::Point3f& p : cloud.points)
    if (isFinite(p))
      points_.push_back({static_cast<float>((p.x - middle_.x) * scale_),
                         static_cast<float>((p.y - middle_.y) * scale_),
                         static_cast<float>((p.z - middle_.z) * scale_), 0});
  if (colorWeight > 0) weighColors(cloud, colorWeight);
}

void Signals::weighColors(const PointCloud& cloud, double weight) {
  if (cloud.colors.empty())
    fail(ErrorCode::invalidInput, "the cloud has no colors, but gng.color-weight is {}; give 0", weight);
  std::vector<cv::Point3f> places;
  std::vector<cv::Vec3f> lab;
  for (const Point4& p : points_) places.emplace_back(p.x, p.y, p.z);
  for (std::size_t i = 0; i < cloud.points.size(); ++i)
    if (isFinite(cloud.points[i])) lab.push_back(labOf(cloud.colors[i]));
  const Neighbors neighbors(places);
  const auto unit = static_cast<float>(weight * spacingOf(neighbors) / estimateColorNoise(neighbors, lab));
  for (const cv::Vec3f& c : lab) colors_.push_back({unit * c[0], unit * c[1], unit * c[2], 0});
}

cv::Point3f Signals::inCloud(const Point4& p) const {
  return {static_cast<float>(p.x / scale_ + middle_.x), static_cast<float>(p.y / scale_ + middle_.y),
          static_cast<float>(p.z / scale_ + middle_.z)};
}

std::vector<Point4> distinctPoints(const std::vector<Point4>& points, std::size_t max) {
  constexpr std::uint32_t none = 0xffffffff;
  max = std::min(max, points.size());
  std::vector<std::uint32_t> table(std::bit_ceil(2 * max + 1), none);
  std::vector<Point4> distinct;
  for (const Point4& p : points) {
    if (distinct.size() == max) break;
    std::size_t at = hash(p) >> 16 & (table.size() - 1);
    while (table[at] != none && !same(distinct[table[at]], p)) at = (at + 1) & (table.size() - 1);
    if (table[at] != none) continue;
    table[at] = static_cast<std::uint32_t>(distinct.size());
    distinct.push_back(p);
  }
  return distinct;
}

}  // namespace estancia
