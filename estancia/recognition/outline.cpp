// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/outline.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "estancia/cloud/neighbors.hpp"
#include "estancia/recognition/pose_score.hpp"

namespace estancia {
namespace {

constexpr float evenDot = 0.94F;  // cosine of 20°: of the normals of an even surface

/// A direction of the tangent plane.
cv::Point3f tangent(const cv::Point3f& normal, std::size_t direction) {
  constexpr float half = std::numbers::sqrt2_v<float> / 2;
  constexpr std::array<std::array<float, 2>, std::tuple_size_v<Outline::Around>> turns{
      {{1, 0}, {half, half}, {0, 1}, {-half, half}, {-1, 0}, {-half, -half}, {0, -1}, {half, -half}}};
  const cv::Point3f aside = std::abs(normal.z) < 0.9F ? cv::Point3f(0, 0, 1) : cv::Point3f(1, 0, 0);
  cv::Point3f u = aside.cross(normal);
  u *= 1 / static_cast<float>(cv::norm(u));
  return u * turns[direction][0] + normal.cross(u) * turns[direction][1];
}

/// The points of a plane while it grows. The plane is fitted again whenever they have doubled.
class Region {
 public:
  Region(const Surface& surface, std::uint32_t seed) : surface_(surface), points_{seed} {
    plane_ = {surface.points()[seed], surface.normals()[seed]};
  }

  const std::vector<std::uint32_t>& points() const { return points_; }
  const Outline::Plane& plane() const { return plane_; }
  void add(std::uint32_t point) { points_.push_back(point); }
  bool fits(std::uint32_t point, double tolerance) const {
    return std::abs(plane_.normal.dot(surface_.points()[point] - plane_.point)) <=
               static_cast<float>(tolerance) &&
           plane_.normal.dot(surface_.normals()[point]) >= evenDot;
  }
  /// Counts the i-th point.
  void visit(std::size_t i) {
    sumOfPoints_ += cv::Point3d(surface_.points()[points_[i]]);
    sumOfNormals_ += cv::Point3d(surface_.normals()[points_[i]]);
    if (i + 1 < 2 * fitted_) return;
    fitted_ = i + 1;
    plane_ = {sumOfPoints_ / static_cast<double>(fitted_), sumOfNormals_ / cv::norm(sumOfNormals_)};
  }

 private:
  const Surface& surface_;
  std::vector<std::uint32_t> points_;
  Outline::Plane plane_;
  cv::Point3d sumOfPoints_, sumOfNormals_;
  std::size_t fitted_ = 1;
};

}  // namespace

Outline::Outline(const Surface& surface, const NearestField& field, const RangeImage& view,
                 const OutlineScales& scales, int threads)
    : step_(static_cast<float>(scales.step)), around_(surface.size()), planeOf_(surface.size(), -1) {
  const auto offset = static_cast<float>(scales.tolerance), aside = step_ / 2;
  const auto stateAt = [&](std::size_t point, std::size_t direction) -> std::int32_t {
    const cv::Point3f at = place(surface, point, direction), &n = surface.normals()[point];
    if (const std::int32_t near = field.at(at); near != NearestField::none) {
      const auto k = static_cast<std::size_t>(near);
      const cv::Point3f off = surface.points()[k] - at;
      const float across = n.dot(off);
      if (std::abs(across) < offset && off.dot(off) - across * across < aside * aside &&
          cosineOf(n, surface.normals()[k], view.known()) > evenDot)
        return near;
    }
    if (!view.known()) return ends;
    const auto depth = view.depth(at);
    return !depth || *depth < at.z - 2 * offset ? unknown : ends;
  };
  inChunks(surface.size(), 4096, threads, "stopped while outlines were looked for",
           [&](std::size_t first, std::size_t last) {
             for (std::size_t i = first; i < last; ++i)
               for (std::size_t d = 0; d < around_[i].size(); ++d) around_[i][d] = stateAt(i, d);
           });
  findPlanes(surface, scales);
}

/// Region growing from points around which the surface goes on, to those that it goes on to. A plane is as
/// large as a disc of two steps: smaller parts of curved things look flat.
void Outline::findPlanes(const Surface& surface, const OutlineScales& scales) {
  constexpr double minRadius = 2;  // steps
  const double perPoint = scales.spacing / (minRadius * scales.step);
  const auto minPoints = static_cast<std::size_t>(std::numbers::pi / (perPoint * perPoint));
  std::vector<std::uint32_t> visited(surface.size(), 0);  // the region that a point was last added to
  std::uint32_t round = 0;
  for (std::uint32_t seed = 0; seed < surface.size(); ++seed) {
    if (visited[seed] != 0 || std::ranges::any_of(around_[seed], [](std::int32_t n) { return n < 0; }))
      continue;
    Region region(surface, seed);
    visited[seed] = ++round;
    for (std::size_t i = 0; i < region.points().size(); ++i) {
      region.visit(i);
      for (const std::int32_t next : around_[region.points()[i]]) {
        if (next < 0) continue;
        const auto k = static_cast<std::uint32_t>(next);
        if (planeOf_[k] >= 0 || visited[k] == round || !region.fits(k, scales.tolerance)) continue;
        visited[k] = round;
        region.add(k);
      }
    }
    if (region.points().size() < minPoints) continue;
    for (const std::uint32_t k : region.points()) planeOf_[k] = static_cast<std::int32_t>(planes_.size());
    planes_.push_back(region.plane());
  }
}

cv::Point3f Outline::place(const Surface& surface, std::size_t point, std::size_t direction) const {
  return surface.points()[point] + tangent(surface.normals()[point], direction) * step_;
}

bool ModelExtent::outside(const cv::Point3f& place) const {
  if (const std::int32_t near = field->at(place); near != NearestField::none) {
    const cv::Point3f off = place - surface->points()[static_cast<std::size_t>(near)];
    if (off.dot(off) < reach * reach) return false;
  }
  if (view == nullptr || !view->known()) return true;
  const cv::Point3f seen = toView * place;
  const auto depth = view->depth(seen);
  return !depth || *depth >= seen.z;  // else the model's own surface hides it
}

}  // namespace estancia
