// SPDX-License-Identifier: Apache-2.0
#include "estancia/cloud/resolution.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "estancia/cloud/neighbors.hpp"
#include "estancia/cloud/normals.hpp"
#include "estancia/core/fail.hpp"

namespace estancia {
namespace {

/// Points spread over the cloud: evenly spaced in the tree's order.
std::vector<cv::Point3f> sampleOf(const Neighbors& points, std::size_t count) {
  std::vector<cv::Point3f> sample;
  const std::size_t n = points.size();
  count = std::min(count, n);
  for (std::size_t i = 0; i < count; ++i) sample.push_back(points.place((2 * i + 1) * n / (2 * count)));
  return sample;
}

/// The diagonal of the bounding box.
double widthOf(const Neighbors& points) {
  if (points.nodes().empty()) return 0;
  const Neighbors::Node& all = points.nodes()[0];
  return std::hypot(all.high[0] - all.low[0], all.high[1] - all.low[1], all.high[2] - all.low[2]);
}

/// The median, or another quantile; reorders.
double quantileOf(std::vector<double>& values, double quantile = 0.5) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(quantile * static_cast<double>(values.size()));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Distance to the nearest point at another place, unless there are more duplicates than a sensor makes.
std::optional<double> nearestOther(const Neighbors& points, const cv::Point3f& place,
                                   std::vector<Neighbor>& buffer) {
  for (const std::size_t count : {2U, 16U, 128U})
    for (const Neighbor& near : points.nearest(place, count, buffer))
      if (near.squared > 0) return std::sqrt(static_cast<double>(near.squared));
  return std::nullopt;
}

/// The points within a ball, relative to its center; reuses `found`.
void collect(const Neighbors& points, const cv::Point3f& middle, double radius,
             std::vector<cv::Vec3d>& found) {
  found.clear();
  points.eachBlock(middle, static_cast<float>(radius * radius), [&](std::uint32_t number) {
    const Neighbors::Block& block = points.blocks()[number];
    for (std::size_t i = 0; i < Neighbors::blockSize; ++i) {
      const cv::Vec3d p(block.x[i] - middle.x, block.y[i] - middle.y, block.z[i] - middle.z);
      if (p.dot(p) <= radius * radius) found.push_back(p);
    }
  });
}

/// The standard deviation of the points within `radius` of a place, across the quadric fitted to them.
std::optional<double> noiseAt(const Neighbors& points, const cv::Point3f& place, double radius) {
  constexpr std::size_t parameters = 6, minPoints = 5 * parameters, maxPoints = 1000;  // enough for a median
  std::vector<cv::Vec3d> near;
  collect(points, place, radius, near);
  if (near.size() < minPoints) return std::nullopt;
  const cv::Vec3d n =
      principalAxes(localCovariance(points, place, static_cast<float>(radius * radius)).covariance).normal;
  if (!(n.dot(n) > 0)) return std::nullopt;
  const cv::Vec3d side = std::abs(n[0]) < 0.5 ? cv::Vec3d(1, 0, 0) : cv::Vec3d(0, 1, 0);
  const cv::Vec3d across = n.cross(side), u = across / cv::norm(across), v = n.cross(u);

  using Terms = cv::Matx<double, parameters, 1>;
  const auto termsOf = [&](const cv::Vec3d& p) {
    const double x = p.dot(u) / radius, y = p.dot(v) / radius;
    return Terms(1, x, y, x * x, x * y, y * y);
  };
  std::size_t used = 0;
  for (std::size_t i = 0; i < near.size(); i += 1 + near.size() / maxPoints) near[used++] = near[i];
  near.resize(used);
  cv::Matx<double, parameters, parameters> squares;
  Terms right, surface;
  for (const cv::Vec3d& p : near) {
    const Terms terms = termsOf(p);
    squares += terms * terms.t();
    right += terms * p.dot(n);
  }
  if (!cv::solve(squares, right, surface, cv::DECOMP_CHOLESKY)) return std::nullopt;
  std::vector<double> residuals;
  residuals.reserve(used);
  for (const cv::Vec3d& p : near) residuals.push_back(std::abs(p.dot(n) - termsOf(p).dot(surface)));
  const double freedom = static_cast<double>(used) / static_cast<double>(used - parameters);
  // The median of the absolute values of a normal distribution times 1.4826 is its standard deviation.
  return 1.4826 * std::sqrt(freedom) * quantileOf(residuals);
}

/// Noise from patches of one size all over the cloud. Edges and corners only add: a quantile below the
/// median.
std::optional<double> noiseOf(const Neighbors& points, double radius, int threads) {
  const auto sample = sampleOf(points, 200);
  std::vector<std::optional<double>> found(sample.size());
  inParallel(sample.size(), threads, Progress::none(), "stopped while the noise was estimated",
             [&](std::size_t i) { found[i] = noiseAt(points, sample[i], radius); });
  std::vector<double> levels;
  for (const auto& level : found)
    if (level) levels.push_back(*level);
  if (levels.empty()) return std::nullopt;
  return quantileOf(levels, 0.4);
}

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

double resolutionOf(const Neighbors& points) {
  std::vector<Neighbor> buffer;
  std::vector<double> distances;
  for (const cv::Point3f& place : sampleOf(points, 2000))
    if (const auto distance = nearestOther(points, place, buffer)) distances.push_back(*distance);
  return distances.empty() ? 0 : quantileOf(distances);
}

double resolutionOf(const PointCloud& cloud) {
  return resolutionOf(Neighbors(cloud.points));
}

double spacingOf(const Neighbors& points) {
  constexpr std::size_t places = 40, minInside = 10, maxInside = 2000;
  const auto wanted = static_cast<double>(std::clamp(points.size() / 100, minInside, maxInside));
  std::vector<double> spacings;
  const double resolution = resolutionOf(points);
  if (!(resolution > 0)) return 0;
  for (const cv::Point3f& place : sampleOf(points, places)) {
    double radius = resolution * std::sqrt(wanted / std::numbers::pi);
    std::size_t inside = 0;
    for (int round = 0; round < 30; ++round, radius *= 1.3) {
      inside = localCovariance(points, place, static_cast<float>(radius * radius)).count;
      if (static_cast<double>(inside) >= wanted) break;
    }
    if (inside > 0) spacings.push_back(radius * std::sqrt(std::numbers::pi / static_cast<double>(inside)));
  }
  return quantileOf(spacings);
}

double estimateNoise(const Neighbors& points, int threads) {
  constexpr double smallest = 10, enough = 6;  // radii, in resolutions and in noise: a ball truncates noise
  constexpr double growth = 2.5;
  double radius = smallest * resolutionOf(points);
  const double largest =
      std::max(radius, widthOf(points) / 6);  // wider patches contain the shape of a small object
  std::optional<double> noise;
  for (int round = 0; round < 6 && radius > 0; ++round) {
    noise = noiseOf(points, radius, threads);
    const double wanted = noise ? enough * *noise : growth * radius;
    if (wanted <= 1.1 * radius) break;
    if (noise && radius >= largest) break;
    radius = std::min(wanted, growth * radius);
    if (noise) radius = std::min(radius, largest);
  }
  return noise.value_or(0);
}

double estimateNoise(const PointCloud& cloud, int threads) {
  return estimateNoise(Neighbors(cloud.points, threads), threads);
}

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
