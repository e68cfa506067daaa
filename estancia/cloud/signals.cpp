#include "estancia/cloud/signals.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "estancia/core/error.hpp"

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

}  // namespace

Signals::Signals(const PointCloud& cloud, std::uint64_t seed) : seed_(seed) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  std::array<double, 3> low{infinity, infinity, infinity}, high{-infinity, -infinity, -infinity};
  std::size_t count = 0;
  for (const cv::Point3f& p : cloud.points) {
    if (!isFinite(p)) continue;
    ++count;
    const std::array<double, 3> v{p.x, p.y, p.z};
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], v[k]);
      high[k] = std::max(high[k], v[k]);
    }
  }
  if (count == 0)
    throw Error(ErrorCode::invalidInput,
                fmt::format("none of the cloud's {} points is finite; a neural gas needs at least one",
                            cloud.points.size()));
  if (count > std::numeric_limits<std::uint32_t>::max())
    throw Error(ErrorCode::tooLarge,
                fmt::format("the cloud has {} points, a neural gas takes at most {}; thin it out first",
                            count, std::numeric_limits<std::uint32_t>::max()));
  double extent = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    middle_[k] = (low[k] + high[k]) / 2;
    extent = std::max(extent, high[k] - middle_[k]);
  }
  int exponent = 0;
  std::frexp(extent, &exponent);
  scale_ = extent > 0 ? std::ldexp(1.0, -exponent) : 1.0;
  points_.reserve(count);
  for (const cv::Point3f& p : cloud.points)
    if (isFinite(p))
      points_.push_back({static_cast<float>((p.x - middle_[0]) * scale_),
                         static_cast<float>((p.y - middle_[1]) * scale_),
                         static_cast<float>((p.z - middle_[2]) * scale_), 0});
}

cv::Point3f Signals::inCloud(const Point4& p) const {
  return {static_cast<float>(p.x / scale_ + middle_[0]), static_cast<float>(p.y / scale_ + middle_[1]),
          static_cast<float>(p.z / scale_ + middle_[2])};
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
