// SPDX-License-Identifier: Apache-2.0
#include "estancia/cloud/normals.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <opencv2/core.hpp>
#include <tuple>

#include "estancia/cloud/disjoint_sets.hpp"
#include "estancia/cloud/growing_neural_gas.hpp"
#include "estancia/cloud/neighbors.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/simd.hpp"

namespace estancia {
namespace {

constexpr std::size_t sumLanes = 16;
constexpr std::size_t sumCount = 10;  // 1, x, y, z, xx, xy, xz, yy, yz, zz

/// The moments of the points within the radius, each lane for itself.
ESTANCIA_MULTIVERSION void add(const Neighbors::Block* all, const std::uint32_t* blocks, std::size_t count,
                               float px, float py, float pz, float squared, float* sums) {
  float lanes[sumCount][sumLanes] = {};
  for (std::size_t b = 0; b < count; ++b) {
    const Neighbors::Block& block = all[blocks[b]];
    for (std::size_t first = 0; first < Neighbors::blockSize; first += sumLanes)
#pragma omp simd
      for (std::size_t l = 0; l < sumLanes; ++l) {
        const float dx = block.x[first + l] - px, dy = block.y[first + l] - py, dz = block.z[first + l] - pz;
        const bool near = dx * dx + dy * dy + dz * dz <= squared;  // NaN is not
        const float x = near ? dx : 0, y = near ? dy : 0, z = near ? dz : 0;
        lanes[0][l] += near ? 1.F : 0.F;
        lanes[1][l] += x;
        lanes[2][l] += y;
        lanes[3][l] += z;
        lanes[4][l] += x * x;
        lanes[5][l] += x * y;
        lanes[6][l] += x * z;
        lanes[7][l] += y * y;
        lanes[8][l] += y * z;
        lanes[9][l] += z * z;
      }
  }
  for (std::size_t s = 0; s < sumCount; ++s)
    for (std::size_t l = 0; l < sumLanes; ++l) sums[s * sumLanes + l] = lanes[s][l];
}

cv::Point3f normalAt(const cv::Point3f& place, const LocalCovariance& local, const cv::Point3f& viewpoint) {
  constexpr float none = std::numeric_limits<float>::quiet_NaN();
  if (local.count < 3) return {none, none, none};
  const cv::Vec3d normal = principalAxes(local.covariance).normal;
  const cv::Vec3d look =
      cv::Vec3d(viewpoint.x, viewpoint.y, viewpoint.z) - cv::Vec3d(place.x, place.y, place.z);
  return cv::Point3d(normal.dot(look) < 0 ? -normal : normal);
}

/// An edge between two points: 1 − |cosine| of their normals, then the lower point.
using NormalEdge = std::tuple<float, std::uint32_t, std::uint32_t>;

/// Each point with its nearest ones, the most parallel first.
std::vector<NormalEdge> edgesByTurn(std::span<const cv::Point3f> points, const Neighbors& neighbors,
                                    const std::vector<cv::Point3f>& normals) {
  constexpr std::size_t near = 10;
  std::vector<NormalEdge> edges;
  edges.reserve(points.size() * near);
  std::vector<Neighbor> buffer;
  for (std::uint32_t i = 0; i < points.size(); ++i)
    for (const Neighbor& n : neighbors.nearest(points[i], near + 1, buffer)) {
      const float turn = 1 - std::abs(normals[i].dot(normals[n.index]));
      if (n.index != i && std::isfinite(turn))
        edges.emplace_back(turn, std::min(i, n.index), std::max(i, n.index));
    }
  std::ranges::sort(edges);
  return edges;
}

/// By PCA of the members.
cv::Point3f normalOf(const std::vector<cv::Point3f>& points, const std::vector<std::uint32_t>& members) {
  constexpr float none = std::numeric_limits<float>::quiet_NaN();
  cv::Vec3d mean;
  for (const std::uint32_t i : members) mean += cv::Vec3d(points[i].x, points[i].y, points[i].z);
  mean /= static_cast<double>(members.size());
  cv::Matx33d covariance = cv::Matx33d::zeros();
  for (const std::uint32_t i : members) {
    const cv::Vec3d d = cv::Vec3d(points[i].x, points[i].y, points[i].z) - mean;
    covariance += d * d.t();
  }
  cv::Vec3d values;
  cv::Matx33d vectors;
  cv::eigen(covariance, values, vectors);  // the largest first
  // Collinear points have no normal; smaller variances are rounding.
  if (!(values[1] > 1e-10 * values[0])) return {none, none, none};
  return {static_cast<float>(vectors(2, 0)), static_cast<float>(vectors(2, 1)),
          static_cast<float>(vectors(2, 2))};
}

}  // namespace

LocalCovariance localCovariance(const Neighbors& points, const cv::Point3f& place, float squared) {
  LocalCovariance local;
  std::array<double, sumCount> totals{};
  std::array<std::uint32_t, 128> blocks;
  std::size_t waiting = 0;
  const auto take = [&] {
    std::array<float, sumCount * sumLanes> sums{};
    add(points.blocks().data(), blocks.data(), waiting, place.x, place.y, place.z, squared, sums.data());
    for (std::size_t s = 0; s < sumCount; ++s)  // in double: long float sums lose digits
      for (std::size_t l = 0; l < sumLanes; ++l) totals[s] += sums[s * sumLanes + l];
    waiting = 0;
  };
  points.eachBlock(place, squared, [&](std::uint32_t block) {
    blocks[waiting++] = block;
    if (waiting == blocks.size()) take();
  });
  take();
  local.count = static_cast<std::size_t>(totals[0]);
  if (local.count == 0) return local;
  for (double& total : totals) total /= static_cast<double>(local.count);
  const auto& [one, x, y, z, xx, xy, xz, yy, yz, zz] = totals;
  local.offset = {x, y, z};
  local.covariance = {xx - x * x, xy - x * y, xz - x * z,  //
                      xy - x * y, yy - y * y, yz - y * z,  //
                      xz - x * z, yz - y * z, zz - z * z};
  return local;
}

PrincipalAxes principalAxes(const cv::Matx33d& c) {
  PrincipalAxes axes;
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  const double mean = (c(0, 0) + c(1, 1) + c(2, 2)) / 3;
  const double a = c(0, 0) - mean, b = c(1, 1) - mean, d = c(2, 2) - mean;
  const double off = c(0, 1) * c(0, 1) + c(0, 2) * c(0, 2) + c(1, 2) * c(1, 2);
  const double p = std::sqrt((a * a + b * b + d * d + 2 * off) / 6);
  if (!(p > 0)) {  // isotropic, or a single point: no direction is special
    axes.variances = {mean, mean, mean};
    axes.normal = {none, none, none};
    return axes;
  }
  const double det = a * (b * d - c(1, 2) * c(1, 2)) - c(0, 1) * (c(0, 1) * d - c(1, 2) * c(0, 2)) +
                     c(0, 2) * (c(0, 1) * c(1, 2) - b * c(0, 2));
  const double angle = std::acos(std::clamp(det / (2 * p * p * p), -1.0, 1.0)) / 3;
  const double largest = mean + 2 * p * std::cos(angle);
  const double smallest = mean + 2 * p * std::cos(angle + 2 * std::numbers::pi / 3);
  axes.variances = {std::max(smallest, 0.0), std::max(3 * mean - largest - smallest, 0.0), largest};
  // Two rows of C - smallest · I span the plane perpendicular to the normal; take the two that span it best.
  const cv::Vec3d rows[] = {{c(0, 0) - smallest, c(0, 1), c(0, 2)},
                            {c(0, 1), c(1, 1) - smallest, c(1, 2)},
                            {c(0, 2), c(1, 2), c(2, 2) - smallest}};
  double longest = 0;
  for (const auto& [i, j] : {std::pair{0, 1}, {0, 2}, {1, 2}}) {
    const cv::Vec3d across = rows[i].cross(rows[j]);
    if (const double length = across.dot(across); length > longest) {
      longest = length;
      axes.normal = across;
    }
  }
  constexpr double line = 1e-6;  // share of the largest variance: below, it is rounding of single precision
  const bool plane = axes.variances[1] > line * largest && longest > 0;
  axes.normal = plane ? axes.normal / std::sqrt(longest) : cv::Vec3d(none, none, none);
  return axes;
}

std::optional<PlaneFit> fitPlane(std::span<const cv::Point3f> points, std::size_t minPoints) {
  if (points.size() < std::max<std::size_t>(minPoints, 3)) return {};
  cv::Vec3d mean;
  for (const cv::Point3f& p : points) mean += cv::Vec3d(p.x, p.y, p.z);
  mean /= static_cast<double>(points.size());
  cv::Matx33d covariance = cv::Matx33d::zeros();
  for (const cv::Point3f& p : points) {
    const cv::Vec3d d = cv::Vec3d(p.x, p.y, p.z) - mean;
    covariance += d * d.t();
  }
  const cv::Vec3d normal = principalAxes(covariance * (1. / static_cast<double>(points.size()))).normal;
  if (std::isnan(normal[0])) return {};
  return PlaneFit{mean, normal};
}

bool isPlanar(std::vector<cv::Point3f> points, double distance) {
  constexpr std::size_t minPoints = 50, maxPoints = 1000;
  constexpr double tolerance = 0.004, minLimit = 0.003, share = 0.95, trimmed = 0.6;  // [m at 1 m]
  if (points.size() < minPoints) return false;
  if (points.size() > maxPoints) {
    for (std::size_t i = 0; i < maxPoints; ++i) points[i] = points[i * points.size() / maxPoints];
    points.resize(maxPoints);
  }
  const double noise = std::max(1., distance * distance);
  std::vector<double> off(points.size()), sorted;
  std::vector<cv::Point3f> kept = points;
  for (int round = 0; round < 5; ++round) {  // trimmed: the other points may be anywhere
    const auto plane = fitPlane(kept);
    if (!plane) return false;
    for (std::size_t i = 0; i < points.size(); ++i) off[i] = std::abs(plane->distance(points[i]));
    sorted = off;
    const auto rank = static_cast<std::ptrdiff_t>(trimmed * static_cast<double>(points.size()));
    std::ranges::nth_element(sorted, sorted.begin() + rank);
    const double near = std::max(minLimit * noise, sorted[static_cast<std::size_t>(rank)]);
    kept.clear();
    for (std::size_t i = 0; i < points.size(); ++i)
      if (off[i] < near) kept.push_back(points[i]);
  }
  const auto on = std::ranges::count_if(off, [&](double d) { return d < tolerance * noise; });
  return static_cast<double>(on) >= share * static_cast<double>(points.size());
}

OptionGroup declare(NormalOptions& o) {
  OptionGroup group("normals", "Surface normals.");
  group.add("radius", &o.radius, "Radius of the points that a plane is fitted to; 0: neighbors decides")
      .range(0)
      .unit("m")
      .why("Larger radii average noise away and round edges off.");
  group.add("neighbors", &o.neighbors, "Nearest points that a plane is fitted to; 0: radius decides");
  group.add("threads", &o.threads, "Threads; 0: one a usable core").range(0);
  return group;
}

void validate(const NormalOptions& options) {
  NormalOptions copy = options;
  declare(copy).validate();
  if ((options.radius > 0) == (options.neighbors > 0))
    fail(ErrorCode::invalidOption,
         "normals.radius is {} m and normals.neighbors is {}; give exactly one above 0", options.radius,
         options.neighbors);
}

std::vector<cv::Point3f> estimateNormals(const PointCloud& cloud, const NormalOptions& options) {
  return estimateNormals(cloud.points, Neighbors(cloud.points, options.threads), options);
}

std::vector<cv::Point3f> estimateNormals(std::span<const cv::Point3f> places, const Neighbors& points,
                                         const NormalOptions& options) {
  validate(options);
  const auto fixed = static_cast<float>(options.radius * options.radius);
  std::vector<cv::Point3f> normals(places.size());
  inChunks(places.size(), 512, options.threads, "stopped while normals were estimated",
           [&](std::size_t first, std::size_t last) {
             std::vector<Neighbor> buffer;
             for (std::size_t i = first; i < last; ++i) {
               float squared = fixed;
               if (options.neighbors > 0) {
                 const auto near = points.nearest(places[i], options.neighbors, buffer);
                 squared = near.empty() ? -1 : near.back().squared;
               }
               normals[i] =
                   normalAt(places[i], localCovariance(points, places[i], squared), options.viewpoint);
             }
           });
  return normals;
}

void orientConsistently(std::span<const cv::Point3f> points, const Neighbors& neighbors,
                        std::vector<cv::Point3f>& normals) {
  if (normals.size() != points.size())
    fail(ErrorCode::invalidInput, "{} normals for {} points; give one a point", normals.size(),
         points.size());
  // Kruskal's tree, and the signs along it
  DisjointSets parts(points.size());
  std::vector<std::vector<std::uint32_t>> tree(points.size());
  for (const auto& [turn, a, b] : edgesByTurn(points, neighbors, normals)) {
    if (parts.find(a) == parts.find(b)) continue;
    parts.join(a, b);
    tree[a].push_back(b);
    tree[b].push_back(a);
  }
  std::vector<bool> reached(points.size());
  std::vector<std::uint32_t> next;
  for (std::uint32_t root = 0; root < points.size(); ++root) {
    if (reached[root]) continue;
    reached[root] = true;
    next.assign(1, root);
    while (!next.empty()) {
      const std::uint32_t i = next.back();
      next.pop_back();
      for (const std::uint32_t j : tree[i]) {
        if (reached[j]) continue;
        reached[j] = true;
        if (normals[i].dot(normals[j]) < 0) normals[j] = -normals[j];
        next.push_back(j);
      }
    }
  }
}

std::vector<cv::Point3f> normalsFromGraph(const NeuralGas& gas, const cv::Point3f& viewpoint) {
  const std::vector<cv::Point3f>& points = gas.cloud.points;
  std::vector<std::vector<std::uint32_t>> around(points.size());
  for (const auto& [a, b] : gas.edges) {
    if (const std::uint32_t end = a >= points.size() ? a : b; end >= points.size())
      fail(ErrorCode::invalidInput,
           "an edge of the graph has neuron {}, but there are {}; give edges and neurons of one graph", end,
           points.size());
    around[a].push_back(b);
    around[b].push_back(a);
  }
  std::vector<cv::Point3f> normals(points.size());
  std::vector<std::uint32_t> members;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    members = {i};
    members.insert(members.end(), around[i].begin(), around[i].end());
    for (const std::uint32_t n : around[i]) members.insert(members.end(), around[n].begin(), around[n].end());
    std::ranges::sort(members);
    members.erase(std::unique(members.begin(), members.end()), members.end());
    const cv::Point3f n = normalOf(points, members);
    normals[i] = n.dot(viewpoint - points[i]) < 0 ? -n : n;
  }
  return normals;
}

}  // namespace estancia
