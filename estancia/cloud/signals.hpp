// Training signals of a neural gas: points of a cloud, drawn at random.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "estancia/core/point_cloud.hpp"

namespace estancia {

/// Four floats in a row; w is 0.
struct alignas(16) Point4 {
  float x = 0, y = 0, z = 0, w = 0;
};

/// Squared distance, always summed in this order and never fused, so that it is the same number everywhere.
inline float squaredDistance(const Point4& a, const Point4& b) {
  const float x = a.x - b.x, y = a.y - b.y, z = a.z - b.z;
  return (x * x + y * y) + z * z;
}

/// The finite points of a cloud, centered and scaled by a power of two into [-1, 1], so that squares neither
/// underflow nor overflow in any unit of length.
class Signals {
 public:
  /// With a `colorWeight` a signal has six dimensions: position, and CIELAB times a factor that makes the
  /// noise of the colors `colorWeight` times the spacing of the points. Throws Error (invalidInput, tooLarge)
  /// when no point is finite, there are 2³² points or more, or a weight meets a cloud without colors.
  Signals(const PointCloud& cloud, std::uint64_t seed, double colorWeight = 0);

  const std::vector<Point4>& points() const { return points_; }
  /// One a point, weighted, in units of length as points() are; empty without a weight.
  const std::vector<Point4>& colors() const { return colors_; }
  /// The index of the point of signal t: splitmix64 (Steele et al. 2014) at position t of the seed's
  /// sequence.
  std::size_t draw(std::uint64_t t) const {
    std::uint64_t z = seed_ + (t + 1) * 0x9e3779b97f4a7c15ULL;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ z >> 27) * 0x94d049bb133111ebULL;
    return static_cast<std::size_t>(((z ^ z >> 31) >> 32) * points_.size() >> 32);
  }
  double scale() const { return scale_; }  ///< lengths here = scale × lengths of the cloud
  cv::Point3f inCloud(const Point4& p) const;

 private:
  void weighColors(const PointCloud& cloud, double weight);

  std::vector<Point4> points_, colors_;
  std::uint64_t seed_;
  double scale_ = 1;
  cv::Point3d middle_;
};

/// The first `max` distinct points, in order of first appearance.
std::vector<Point4> distinctPoints(const std::vector<Point4>& points, std::size_t max);

}  // namespace estancia
