// SPDX-License-Identifier: Apache-2.0
#include "estancia/cloud/mls_surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "estancia/cloud/neighbors.hpp"
#include "estancia/cloud/normals.hpp"
#include "estancia/cloud/voxel_grid.hpp"
#include "estancia/core/simd.hpp"

namespace estancia {
namespace {

constexpr std::size_t mlsLanes = 16;
constexpr std::size_t mlsSums = 10;  // 1, x, y, z, xx, xy, xz, yy, yz, zz

/// Weights and normals of the points of a block; a normal of 0, 0, 0 is unknown.
struct alignas(64) Weights {
  float weight[Neighbors::blockSize], x[Neighbors::blockSize], y[Neighbors::blockSize],
      z[Neighbors::blockSize];
};

struct Ball {
  cv::Vec3f middle;
  float squared;     ///< squared radius
  cv::Vec3f facing;  ///< points with an opposite normal do not count
};

/// Weighted moments, Tukey's weights of the distance.
ESTANCIA_MULTIVERSION void addBall(const Neighbors::Block* blocks, const Weights* weights,
                                   const std::uint32_t* numbers, std::size_t count, const Ball& ball,
                                   float* sums) {
  float lanes[mlsSums][mlsLanes] = {};
  const float px = ball.middle[0], py = ball.middle[1], pz = ball.middle[2], inverse = 1 / ball.squared;
  const float fx = ball.facing[0], fy = ball.facing[1], fz = ball.facing[2];
  for (std::size_t b = 0; b < count; ++b) {
    const Neighbors::Block& block = blocks[numbers[b]];
    const Weights& w = weights[numbers[b]];
    for (std::size_t first = 0; first < Neighbors::blockSize; first += mlsLanes)
#pragma omp simd
      for (std::size_t l = 0; l < mlsLanes; ++l) {
        const std::size_t i = first + l;
        const float dx = block.x[i] - px, dy = block.y[i] - py, dz = block.z[i] - pz;
        const float left = 1 - (dx * dx + dy * dy + dz * dz) * inverse;
        const bool counts = (left > 0) & (w.x[i] * fx + w.y[i] * fy + w.z[i] * fz >= 0);  // NaN is not
        const float g = counts ? w.weight[i] * left * left : 0;
        const float x = counts ? dx : 0, y = counts ? dy : 0, z = counts ? dz : 0;
        lanes[0][l] += g;
        lanes[1][l] += g * x;
        lanes[2][l] += g * y;
        lanes[3][l] += g * z;
        lanes[4][l] += g * x * x;
        lanes[5][l] += g * x * y;
        lanes[6][l] += g * x * z;
        lanes[7][l] += g * y * y;
        lanes[8][l] += g * y * z;
        lanes[9][l] += g * z * z;
      }
  }
  for (std::size_t s = 0; s < mlsSums; ++s)
    for (std::size_t l = 0; l < mlsLanes; ++l) sums[s] += lanes[s][l];
}

struct Cylinder {
  cv::Vec3f middle, axis;
  float squaredWidth, depth;
  cv::Vec3f facing;
};

/// Weights and weighted heights along the axis, Tukey's weights of the distance from it.
ESTANCIA_MULTIVERSION void addCylinder(const Neighbors::Block* blocks, const Weights* weights,
                                       const std::uint32_t* numbers, std::size_t count,
                                       const Cylinder& cylinder, float* sums) {
  float weight[mlsLanes] = {}, height[mlsLanes] = {};
  const float px = cylinder.middle[0], py = cylinder.middle[1], pz = cylinder.middle[2];
  const float ax = cylinder.axis[0], ay = cylinder.axis[1], az = cylinder.axis[2];
  const float fx = cylinder.facing[0], fy = cylinder.facing[1], fz = cylinder.facing[2];
  const float inverse = 1 / cylinder.squaredWidth, depth = cylinder.depth;
  for (std::size_t b = 0; b < count; ++b) {
    const Neighbors::Block& block = blocks[numbers[b]];
    const Weights& w = weights[numbers[b]];
    for (std::size_t first = 0; first < Neighbors::blockSize; first += mlsLanes)
#pragma omp simd
      for (std::size_t l = 0; l < mlsLanes; ++l) {
        const std::size_t i = first + l;
        const float dx = block.x[i] - px, dy = block.y[i] - py, dz = block.z[i] - pz;
        const float h = dx * ax + dy * ay + dz * az;
        const float left = 1 - (dx * dx + dy * dy + dz * dz - h * h) * inverse;
        const bool counts =
            (left > 0) & (std::abs(h) <= depth) & (w.x[i] * fx + w.y[i] * fy + w.z[i] * fz >= 0);
        const float g = counts ? w.weight[i] * left * left : 0;
        weight[l] += g;
        height[l] += g * (counts ? h : 0);
      }
  }
  for (std::size_t l = 0; l < mlsLanes; ++l) sums[0] += weight[l], sums[1] += height[l];
}

/// The voxels that are averaged over.
class Support {
 public:
  Support(const PointCloud& voxels, const std::vector<std::uint32_t>& counts, double perPoint, int threads)
      : points_(voxels.points, threads), weights_(points_.blocks().size()) {
    for (std::size_t b = 0; b < weights_.size(); ++b)
      for (std::size_t i = 0; i < Neighbors::blockSize; ++i) {
        Weights& w = weights_[b];
        w.weight[i] = w.x[i] = w.y[i] = w.z[i] = 0;
        if (b * Neighbors::blockSize + i >= points_.size()) continue;
        const std::uint32_t index = points_.blocks()[b].index[i];
        w.weight[i] = static_cast<float>(counts[index] * perPoint);
        if (voxels.normals.empty()) continue;
        const cv::Point3f& n = voxels.normals[index];
        if (std::isfinite(n.x + n.y + n.z)) w.x[i] = n.x, w.y[i] = n.y, w.z[i] = n.z;
      }
    for (const cv::Point3f& n : voxels.normals)
      normals_.push_back(std::isfinite(n.x + n.y + n.z) ? cv::Vec3f(n.x, n.y, n.z) : cv::Vec3f());
  }

  /// The voxel nearest to `place`.
  std::uint32_t nearest(const cv::Point3f& place, std::vector<Neighbor>& buffer) const {
    return points_.nearest(place, 1, buffer)[0].index;
  }

  /// The normal of the nearest point; 0, 0, 0 when it is unknown.
  cv::Vec3f facing(const cv::Point3f& place, std::vector<Neighbor>& buffer) const {
    if (normals_.empty()) return {};
    const auto near = points_.nearest(place, 1, buffer);
    return near.empty() ? cv::Vec3f() : normals_[near[0].index];
  }

  std::array<float, mlsSums> ball(const Ball& ball, std::vector<std::uint32_t>& numbers) const {
    numbers.clear();
    points_.eachBlock(cv::Point3f(ball.middle), ball.squared,
                      [&](std::uint32_t number) { numbers.push_back(number); });
    std::array<float, mlsSums> sums{};
    addBall(points_.blocks().data(), weights_.data(), numbers.data(), numbers.size(), ball, sums.data());
    return sums;
  }

  std::array<float, 2> cylinder(const Cylinder& c, std::vector<std::uint32_t>& numbers) const {
    const float width = std::sqrt(c.squaredWidth);
    float low[3], high[3];
    for (int k = 0; k < 3; ++k) {
      const float half =
          c.depth * std::abs(c.axis[k]) + width * std::sqrt(std::max(0.F, 1 - c.axis[k] * c.axis[k]));
      low[k] = c.middle[k] - half, high[k] = c.middle[k] + half;
    }
    numbers.clear();
    const auto nodes = points_.nodes();
    for (std::size_t i = 0; i < nodes.size();) {
      const Neighbors::Node& node = nodes[i];
      const bool apart = node.high[0] < low[0] || node.low[0] > high[0] || node.high[1] < low[1] ||
                         node.low[1] > high[1] || node.high[2] < low[2] || node.low[2] > high[2];
      if (!apart && node.last == node.first + 1) numbers.push_back(node.first);
      i = apart ? node.skip : i + 1;
    }
    std::array<float, 2> sums{};
    addCylinder(points_.blocks().data(), weights_.data(), numbers.data(), numbers.size(), c, sums.data());
    return sums;
  }

 private:
  Neighbors points_;
  std::vector<Weights> weights_;
  std::vector<cv::Vec3f> normals_;
};

/// A projected seed.
struct Element {
  cv::Point3f place, normal;
  float weight = -1;  ///< weight of the averaged points; negative: too few
};

Element meanAt(const cv::Point3f& seed, const Support& support, const MlsOptions& o,
               std::vector<Neighbor>& buffer, std::vector<std::uint32_t>& numbers) {
  constexpr int rounds = 2;
  constexpr float minInBall = 6, minInCylinder = 3;
  const cv::Vec3f facing = support.facing(seed, buffer);
  const auto squared = static_cast<float>(o.radius * o.radius);
  Element element;
  cv::Vec3f p(seed.x, seed.y, seed.z), normal;
  float weight = 0;
  for (int round = 0; round < rounds; ++round) {
    const auto m = support.ball({p, squared, facing}, numbers);
    if (!(m[0] >= minInBall)) return element;
    const double w = m[0], x = m[1] / w, y = m[2] / w, z = m[3] / w;
    normal = principalAxes({m[4] / w - x * x, m[5] / w - x * y, m[6] / w - x * z,  //
                            m[5] / w - x * y, m[7] / w - y * y, m[8] / w - y * z,  //
                            m[6] / w - x * z, m[8] / w - y * z, m[9] / w - z * z})
                 .normal;
    if (!std::isfinite(normal[0])) return element;
    const auto [sum, heights] = support.cylinder(
        {p, normal, static_cast<float>(o.width * o.width), static_cast<float>(o.depth), facing}, numbers);
    if (!(sum >= minInCylinder)) return element;
    p += normal * (heights / sum);
    weight = sum;
  }
  const cv::Vec3f moved = p - cv::Vec3f(seed.x, seed.y, seed.z);
  if (cv::norm(moved) >= 1.2 * o.depth) return element;
  const cv::Vec3f look = cv::Vec3f(o.viewpoint.x, o.viewpoint.y, o.viewpoint.z) - p;
  const float towards =
      facing.dot(facing) > 0 ? normal.dot(facing) : normal.dot(look) * (o.away ? -1.F : 1.F);
  if (towards < 0) normal = -normal;
  return {cv::Point3f(p), cv::Point3f(normal), weight};
}

}  // namespace

PointCloud projectMls(const std::vector<cv::Point3f>& seeds, const PointCloud& cloud,
                      const MlsOptions& options) {
  std::vector<std::uint32_t> counts;
  const PointCloud voxels = voxelGrid(cloud, options.leaf, &counts);
  const Support support(voxels, counts, options.perPoint, options.threads);
  const std::vector<cv::Point3f>& from = seeds.empty() ? voxels.points : seeds;

  std::vector<Element> elements(from.size());
  inChunks(from.size(), 256, options.threads, "stopped while a surface was smoothed",
           [&](std::size_t first, std::size_t last) {
             std::vector<Neighbor> buffer;
             std::vector<std::uint32_t> numbers;
             for (std::size_t i = first; i < last; ++i)
               elements[i] = meanAt(from[i], support, options, buffer, numbers);
           });

  // Elements with few points around are outliers, or beyond an edge.
  constexpr float thin = 0.15F;
  std::vector<float> weights;
  for (const Element& e : elements) weights.push_back(std::max(e.weight, 0.F));
  float minWeight = 0;
  if (!weights.empty()) {
    const auto middle = weights.begin() + static_cast<std::ptrdiff_t>(weights.size() / 2);
    std::nth_element(weights.begin(), middle, weights.end());
    minWeight = thin * *middle;
  }
  std::erase_if(elements, [&](const Element& e) { return e.weight < 0 || e.weight <= minWeight; });

  PointCloud surface;
  std::vector<Neighbor> buffer;
  const auto keep = [&](const Element& e) {
    surface.points.push_back(e.place);
    surface.normals.push_back(e.normal);
    if (!voxels.colors.empty()) surface.colors.push_back(voxels.colors[support.nearest(e.place, buffer)]);
  };
  if (options.spacing > 0) {
    std::vector<cv::Point3f> places;
    for (const Element& e : elements) places.push_back(e.place);
    for (const std::uint32_t i : onePerVoxel(places, options.spacing)) keep(elements[i]);
  } else {
    for (const Element& e : elements) keep(e);
  }
  surface.width = surface.points.size();
  surface.height = 1;
  return surface;
}

}  // namespace estancia
