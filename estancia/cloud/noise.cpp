// SPDX-License-Identifier: Apache-2.0
#include "estancia/cloud/noise.hpp"

#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <utility>

#include "estancia/core/fail.hpp"

namespace estancia {
namespace {

/// Box and Muller 1958, because std::normal_distribution differs between standard libraries.
class Gaussian {
 public:
  explicit Gaussian(std::uint64_t seed) : bits_(seed) {}

  double operator()() {
    if (kept_) return *std::exchange(kept_, std::nullopt);
    const double radius = std::sqrt(-2 * std::log(1 - uniform())), angle = 2 * std::numbers::pi * uniform();
    kept_ = radius * std::sin(angle);
    return radius * std::cos(angle);
  }

 private:
  /// In [0, 1).
  double uniform() { return static_cast<double>(bits_() >> 11U) * 0x1p-53; }

  std::mt19937_64 bits_;  // the standard fixes its numbers
  std::optional<double> kept_;
};

void requireDeviation(double sigma) {
  if (!(sigma >= 0) || !std::isfinite(sigma))
    fail(ErrorCode::invalidOption, "the standard deviation of the noise is {} m; give 0 or more", sigma);
}

}  // namespace

PointCloud withDepthNoise(PointCloud cloud, double atOneMeter, double across, std::uint64_t seed) {
  requireDeviation(atOneMeter);
  requireDeviation(across);
  Gaussian draw(seed);
  for (cv::Point3f& p : cloud.points) {
    const double z = p.z, along = 1 + atOneMeter * z * draw();
    const double x = (p.x + across * z * draw()) * along, y = (p.y + across * z * draw()) * along;
    p = {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z * along)};
  }
  return cloud;
}

PointCloud withGaussianNoise(PointCloud cloud, double sigma, std::uint64_t seed) {
  requireDeviation(sigma);
  if (sigma == 0) return cloud;
  Gaussian draw(seed);
  for (cv::Point3f& p : cloud.points)
    for (float* value : {&p.x, &p.y, &p.z}) *value = static_cast<float>(*value + sigma * draw());
  return cloud;
}

}  // namespace estancia
