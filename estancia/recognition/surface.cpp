// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/surface.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "estancia/cloud/bounds.hpp"
#include "estancia/cloud/color_lab.hpp"
#include "estancia/cloud/resolution.hpp"
#include "estancia/cloud/voxel_grid.hpp"
#include "estancia/core/fail.hpp"

namespace estancia {
namespace {

template <class Value>
std::vector<Value> kept(const PointCloud& cloud, const std::vector<Value>& values) {
  std::vector<Value> left;
  if (cloud.normals.size() != cloud.points.size() || values.empty()) return left;
  left.reserve(values.size());
  for (std::size_t i = 0; i < cloud.points.size(); ++i)
    if (isFinite(cloud.points[i]) && isFinite(cloud.normals[i])) left.push_back(values[i]);
  return left;
}

OrientedPoints chosenFrom(const Surface& surface, const std::vector<std::uint32_t>& indices) {
  OrientedPoints chosen;
  for (const std::uint32_t i : indices) {
    chosen.points.push_back(surface.points()[i]);
    chosen.normals.push_back(surface.normals()[i]);
    if (!surface.lab().empty()) chosen.lab.push_back(surface.lab()[i]);
  }
  return chosen;
}

std::vector<std::uint32_t> uniform(const Surface& surface, double spacing) {
  // Below, voxels exceed the precision of a float.
  if (!(spacing > 1e-6 * surface.resolution()))
    fail(ErrorCode::invalidOption,
         "{}: the keypoint spacing is {} m on a cloud of {:.4g} m; give about {:.4g} m", surface.name(),
         spacing, surface.extent(), 5 * surface.resolution());
  return onePerVoxel(surface.points(), spacing);
}

/// Non-maximum suppression: the points whose response is positive and the largest within `radius`; the first
/// of equal ones.
std::vector<std::uint32_t> strongest(const Surface& surface, const std::vector<float>& response,
                                     double radius, int threads) {
  std::vector<char> isKeypoint(surface.size(), 0);
  surface.neighbors().eachWithin(
      static_cast<float>(radius), threads, [&](std::uint32_t i, std::span<const Neighbor> near) {
        isKeypoint[i] =
            response[i] > 0 && std::all_of(near.begin(), near.end(), [&](const Neighbor& n) {
              return response[n.index] < response[i] || (response[n.index] == response[i] && n.index >= i);
            });
      });
  std::vector<std::uint32_t> chosen;
  for (std::uint32_t i = 0; i < surface.size(); ++i)
    if (isKeypoint[i]) chosen.push_back(i);
  return chosen;
}

/// Σ v vᵀ
struct Scatter {
  float xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  void add(const cv::Point3f& v) {
    xx += v.x * v.x, xy += v.x * v.y, xz += v.x * v.z, yy += v.y * v.y, yz += v.y * v.z, zz += v.z * v.z;
  }
};

std::vector<std::uint32_t> harris3d(const Surface& surface, double spacing, int threads) {
  std::vector<float> response(surface.size(), 0);
  surface.neighbors().eachWithin(
      static_cast<float>(spacing), threads, [&](std::uint32_t i, std::span<const Neighbor> near) {
        Scatter sum;
        for (const Neighbor& n : near) sum.add(surface.normals()[n.index]);
        const auto [xx, xy, xz, yy, yz, zz] = sum;
        const double per = 1.0 / static_cast<double>(near.size());
        const double trace = (xx + yy + zz) * per;
        const double det =
            per * per * per *
            (static_cast<double>(xx) * yy * zz + 2.0 * xy * xz * yz - static_cast<double>(xz) * xz * yy -
             static_cast<double>(xy) * xy * zz - static_cast<double>(yz) * yz * xx);
        response[i] = static_cast<float>(0.04 + det - 0.04 * trace * trace);
      });
  // Unit normals have a trace of 1: on a plane, rounding of 0.04 − 0.04 must not make corners.
  for (float& r : response)
    if (r < 1e-6F) r = 0;
  return strongest(surface, response, spacing, threads);
}

std::vector<std::uint32_t> iss(const Surface& surface, double spacing, int threads) {
  constexpr double ratio = 0.975;
  std::vector<float> salience(surface.size(), 0);
  surface.neighbors().eachWithin(
      static_cast<float>(spacing), threads, [&](std::uint32_t i, std::span<const Neighbor> near) {
        if (near.size() < 5) return;
        const cv::Point3f& p = surface.points()[i];
        Scatter sum;
        for (const Neighbor& n : near) sum.add(surface.points()[n.index] - p);
        const auto [xx, xy, xz, yy, yz, zz] = sum;
        Eigen::Matrix3d scatter;
        scatter << xx, xy, xz, xy, yy, yz, xz, yz, zz;
        const Eigen::Vector3d e =
            Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter, Eigen::EigenvaluesOnly).eigenvalues();
        // Eigenvalues from rounding are ignored: a plane has no salient point.
        if (e[0] > 1e-6 * e[2] && e[1] < ratio * e[2] && e[0] < ratio * e[1])
          salience[i] = static_cast<float>(e[0]);
      });
  return strongest(surface, salience, spacing * 2 / 3, threads);
}

}  // namespace

Surface::Surface(std::string name, const PointCloud& cloud, int threads)
    : name_(std::move(name)),
      points_(kept(cloud, cloud.points)),
      normals_(kept(cloud, cloud.normals)),
      lab_(labOf(kept(cloud, cloud.colors))),
      neighbors_(points_, threads) {
  if (points_.empty())
    fail(ErrorCode::invalidInput,
         "{}: none of its {} points has a normal; give a cloud of a surface, and a normal "
         "radius that contains some points",
         name_, cloud.points.size());
  resolution_ = resolutionOf(neighbors_);
  extent_ = extentOf(points_);
}

Surface Surface::withNormals(std::vector<cv::Point3f> normals) const {
  Surface other = *this;
  other.normals_ = std::move(normals);
  return other;
}

double extentOf(std::span<const cv::Point3f> points) {
  const Bounds<float> box = boundsOf(points);
  return box.empty() ? 0 : cv::norm(box.high - box.low);
}

cv::Point3d meanOf(std::span<const cv::Point3f> points) {
  cv::Point3d sum;
  for (const cv::Point3f& p : points) sum += cv::Point3d(p);
  return sum / static_cast<double>(points.size());
}

void requireRadius(const std::string& name, std::span<const cv::Point3f> points, const Neighbors& neighbors,
                   double radius, const std::string& what) {
  constexpr std::size_t minNeighbors = 5;
  if (!(radius > 0) || !std::isfinite(radius))
    fail(ErrorCode::invalidOption, "{}: the {} is {} m; give a positive one", name, what, radius);
  const double extent = extentOf(points), resolution = resolutionOf(neighbors);
  if (!(resolution > 0))
    fail(ErrorCode::invalidInput, "{}: all of its {} points coincide; give a cloud of a surface", name,
         points.size());
  std::vector<float> needed;  // squared radius that contains enough neighbors
  std::vector<Neighbor> buffer;
  const std::size_t step = std::max<std::size_t>(points.size() / 1000, 1);
  for (std::size_t i = 0; i < points.size(); i += step)
    if (const auto near = neighbors.nearest(points[i], minNeighbors + 1, buffer);
        near.size() == minNeighbors + 1)
      needed.push_back(near.back().squared);
  const auto middle = needed.begin() + static_cast<std::ptrdiff_t>(needed.size() / 2);
  std::nth_element(needed.begin(), middle, needed.end());
  const double reach = needed.empty() ? extent : std::sqrt(*middle);
  const double advised = std::min(std::max(10 * resolution, 1.5 * reach), extent / 3);
  if (radius >= reach && radius <= extent) return;
  if (advised < 1.1 * reach)
    fail(ErrorCode::insufficientData, "{}: {} points are too few to be described; give a denser cloud", name,
         points.size());
  fail(ErrorCode::mismatch,
       "{}: a {} of {:.4g} m {} of a cloud of {:.4g} m with points {:.4g} m apart; scale it if it "
       "is in other units, else give about {:.4g} m",
       name, what, radius, radius < reach ? "leaves most points without neighbors" : "exceeds the extent",
       extent, resolution, advised);
}

OrientedPoints spreadPoints(const Surface& surface, std::size_t count) {
  if (surface.size() <= count || !(surface.extent() > 0))
    return {surface.points(), surface.normals(), {}, surface.lab()};
  // Bisection: half the edge of a voxel, four times as many points.
  double low = surface.extent() / 1e5, high = surface.extent();
  std::vector<std::uint32_t> best;
  for (int step = 0; step < 12; ++step) {
    const double middle = std::sqrt(low * high);
    std::vector<std::uint32_t> chosen = findKeypoints(surface, "uniform", middle);
    const bool tooMany = chosen.size() > count;
    if (best.empty() || (!tooMany && chosen.size() > best.size()) || best.size() > count)
      best = std::move(chosen);
    (tooMany ? low : high) = middle;
  }
  return chosenFrom(surface, best);
}

OrientedPoints spreadPointsBy(const Surface& surface, double spacing, std::size_t most) {
  return chosenFrom(surface, partOf(findKeypoints(surface, "uniform", spacing), most));
}

std::vector<std::uint32_t> partOf(std::vector<std::uint32_t> indices, std::size_t count) {
  const std::size_t size = indices.size();
  if (size <= count) return indices;
  for (std::size_t k = 0; k < count; ++k) indices[k] = indices[k * size / count];
  indices.resize(count);
  return indices;
}

Choices keypointMethods() {
  return {{"uniform", "one point a voxel"},
          {"harris3d", "where normals vary in all directions"},
          {"iss", "intrinsic shape signatures: three different variances of the points around"}};
}

std::vector<std::uint32_t> findKeypoints(const Surface& surface, const std::string& method, double spacing,
                                         int threads) {
  if (!(spacing > 0) || !std::isfinite(spacing))
    fail(ErrorCode::invalidOption, "{}: the keypoint spacing is {} m; give a positive one", surface.name(),
         spacing);
  requireChoice("keypoint detector", method, keypointMethods());
  if (method == "uniform") return uniform(surface, spacing);
  return method == "harris3d" ? harris3d(surface, spacing, threads) : iss(surface, spacing, threads);
}

}  // namespace estancia
