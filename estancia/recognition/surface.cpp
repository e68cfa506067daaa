// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/surface.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "estancia/cloud/bounds.hpp"
#include "estancia/cloud/color_lab.hpp"
#include "estancia/cloud/resolution.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/recognition/keypoints.hpp"

namespace estancia {
namespace {

constexpr std::size_t samples = 1000;  // points at which distances are measured

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
  const std::size_t step = std::max<std::size_t>(points.size() / samples, 1);
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

OrientedPoints spreadPointsBy(const Surface& surface, double spacing) {
  return chosenFrom(surface, findKeypoints(surface, "uniform", spacing));
}

}  // namespace estancia
