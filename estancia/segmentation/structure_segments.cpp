// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <utility>

#include "estancia/cloud/normals.hpp"
#include "estancia/segmentation/segmentation_stages.hpp"

namespace estancia {
namespace {

constexpr double foreground = 0.1;                     // share of the border of what stands before something
constexpr double nearBefore = 0.15, nearBehind = 0.3;  // what lines a wall lies so near to it [m]
constexpr double strip = 0.12, minLength = 0.3;        // width and length of skirting, frames and reveals [m]
constexpr float maxBreak = 0.03F;                      // difference of 1/z from the plane

/// The connected pixels of plane `number` around pixel `first`; clears them in `of`.
void takePatch(const InverseDepth& grid, const Plane& plane, std::size_t first, std::vector<std::uint8_t>& of,
               std::vector<std::uint32_t>& patch) {
  const std::uint8_t number = of[first];
  const auto stepX = static_cast<float>(plane.normal[0] / plane.offset / grid.camera.fx);
  const auto stepY = static_cast<float>(plane.normal[1] / plane.offset / grid.camera.fy);
  const std::pair<std::ptrdiff_t, float> around[] = {
      {1, stepX}, {-1, -stepX}, {grid.stride, stepY}, {-grid.stride, -stepY}};
  patch.assign(1, static_cast<std::uint32_t>(first));
  of[first] = 0;
  for (std::size_t k = 0; k < patch.size(); ++k)
    for (const auto& [step, slope] : around) {
      const auto j = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(patch[k]) + step);
      if (of[j] != number) continue;
      if (std::abs(grid.raw[j] - grid.raw[patch[k]] - slope) > maxBreak * grid.raw[j]) continue;
      of[j] = 0;
      patch.push_back(static_cast<std::uint32_t>(j));
    }
}

/// Points of a segment.
struct Points {
  std::vector<cv::Point3f> all;
  double area = 0;  ///< visible area [m²]
};

std::vector<Points> segmentPoints(const InverseDepth& grid, const Mask& mask, const Segmentation& segments) {
  std::vector<Points> points(segments.sizes.size());
  const double pixel = 1 / (grid.camera.fx * grid.camera.fy);
  mask.eachPixel([&](std::size_t i) {
    const std::uint32_t label = segments.labels[i];
    if (label == 0) return;
    const cv::Point3f p = grid.point(i);
    points[label].all.push_back(p);
    points[label].area += pixel * p.z * p.z;
  });
  return points;
}

bool isFlatOrTiny(const Points& points) {
  if (points.all.size() < 50) return true;
  double z = 0;
  for (const cv::Point3f& p : points.all) z += p.z;
  return isPlanar(points.all, z / static_cast<double>(points.all.size()));
}

/// Whether nearly all points are near the wall, along a line.
bool isStripAlong(const Plane& wall, const Points& points) {
  const auto n = static_cast<double>(points.all.size());
  double near = 0;
  cv::Vec3d sum;
  cv::Matx33d squares = cv::Matx33d::zeros();
  for (const cv::Point3f& point : points.all) {
    const cv::Vec3d p(point.x, point.y, point.z);
    const double off = wall.normal.dot(p) - wall.offset;
    near += off > -nearBehind && off < nearBefore ? 1 : 0;
    const cv::Vec3d on = p - off * wall.normal;
    sum += on;
    squares += on * on.t();
  }
  if (near < 0.9 * n) return false;
  const cv::Matx33d spread = squares * (1 / n) - sum * sum.t() * (1 / (n * n));
  cv::Vec3d variances;
  cv::eigen(spread, variances);
  const double length = std::sqrt(12 * std::max(0., variances[0]));  // length of an even strip
  return length > minLength && points.area < strip * length;
}

constexpr double level = 0.17;       // sine of the slope of a level surface: 10°
constexpr double foreshortened = 4;  // pixels of a surface at a right angle to the ray: at 14°, normals fail

/// From a pixel to the one above it, as gravity has it.
std::ptrdiff_t stepUp(const InverseDepth& grid, const cv::Vec3d& up) {
  if (std::abs(up[0]) > std::abs(up[1])) return up[0] > 0 ? 1 : -1;
  return up[1] > 0 ? grid.stride : -grid.stride;
}

}  // namespace

Segmentation takePatches(const InverseDepth& grid, PlaneRemoval& removal) {
  Segmentation patches;
  patches.labels.resize(grid.size());
  patches.sizes.resize(1);
  std::vector<std::uint8_t> of = removal.of;
  std::vector<std::uint32_t> patch;
  std::vector<std::uint8_t> rest = removal.rest.in;
  for (std::size_t i = 0; i < of.size(); ++i) {
    if (of[i] == 0 || removal.planes[of[i] - 1U].structural) continue;
    takePatch(grid, removal.planes[of[i] - 1U], i, of, patch);
    const bool large = static_cast<double>(patch.size()) >= grid.area(minSegmentArea);
    for (const std::uint32_t j : patch) {
      if (large)
        patches.labels[j] = static_cast<std::uint32_t>(patches.sizes.size());
      else
        rest[j] = 1;
    }
    if (large) patches.sizes.push_back(static_cast<std::uint32_t>(patch.size()));
  }
  removal.rest = Mask(grid, std::move(rest));
  return patches;
}

void dropGrazedLevels(const InverseDepth& grid, const cv::Vec3d& up, PlaneRemoval& removal) {
  if (!(cv::norm(up) > 0)) return;
  const std::ptrdiff_t step = stepUp(grid, up);
  const double focal = std::abs(step) == 1 ? grid.camera.fx : grid.camera.fy;
  // Whether the surface from a pixel to the one above it is level and recedes.
  const auto recedes = [&](std::size_t i, std::size_t above) {
    if (!(grid.raw[i] > 0) || !(grid.raw[above] > 0) || grid.raw[above] >= grid.raw[i]) return false;
    const cv::Point3f p = grid.point(i), q = grid.point(above);
    const cv::Vec3d along(q.x - p.x, q.y - p.y, q.z - p.z);
    const double length = cv::norm(along), z = q.z;
    return length > foreshortened * z / focal + differenceNoise * z * z &&
           std::abs(along.dot(up)) < level * length;
  };
  std::vector<std::uint8_t> in = removal.rest.in;
  removal.rest.eachPixel([&](std::size_t i) {
    const auto at = static_cast<std::ptrdiff_t>(i);
    const auto above = static_cast<std::size_t>(at + step), below = static_cast<std::size_t>(at - step);
    if (recedes(i, above) && recedes(below, i)) in[i] = 0;
  });
  removal.rest = Mask(grid, std::move(in));
}

Mask dropStructure(const InverseDepth& grid, const PlaneRemoval& removal, const cv::Vec3d& up,
                   const Segmentation& patches, Segmentation& segments) {
  const std::size_t first = segments.sizes.size();  // first of the patches
  std::vector<std::uint8_t> in = removal.rest.in;
  for (std::size_t i = 0; i < in.size(); ++i) {
    if (patches.labels[i] == 0) continue;
    segments.labels[i] = static_cast<std::uint32_t>(first) - 1 + patches.labels[i];
    in[i] = 1;
  }
  segments.sizes.insert(segments.sizes.end(), patches.sizes.begin() + 1, patches.sizes.end());
  const std::vector<SegmentEdge> edges = segmentGraph(grid, segments, up);
  struct Border {
    std::size_t all = 0, inFront = 0, atBounds = 0, atOthers = 0;
  };
  std::vector<Border> borders(segments.sizes.size());
  for (const SegmentEdge& e : edges) {
    for (const std::uint32_t i : {e.a, e.b}) {
      borders[i].all += e.contacts + e.aInFront + e.bInFront;
      borders[i].inFront += i == e.a ? e.aInFront : e.bInFront;
      (e.a == 0 ? borders[i].atBounds : borders[i].atOthers) += e.contacts;
    }
  }
  const std::vector<Points> points = segmentPoints(grid, removal.rest, segments);
  std::vector<std::uint8_t> isDropped(segments.sizes.size());
  for (std::size_t i = 1; i < first; ++i) {
    const Border& border = borders[i];
    const bool behind = static_cast<double>(border.inFront) < foreground * static_cast<double>(border.all) &&
                        border.atBounds >= border.atOthers && isFlatOrTiny(points[i]);
    isDropped[i] =
        behind || std::ranges::any_of(removal.planes, [&](const Plane& plane) {
          return plane.structural && std::abs(plane.normal.dot(up)) < 0.5 && isStripAlong(plane, points[i]);
        });
    if (isDropped[i] != 0) segments.sizes[i] = 0;
  }
  for (std::size_t i = 0; i < in.size(); ++i) {
    if (isDropped[segments.labels[i]] == 0) continue;
    segments.labels[i] = 0;
    in[i] = 0;
  }
  for (const SegmentEdge& e : edges)
    if (e.a != 0 && e.contacts >= minBorderPairs) segments.touching.emplace_back(e.a, e.b);
  std::erase_if(segments.touching,
                [&](const auto& pair) { return isDropped[pair.first] != 0 || isDropped[pair.second] != 0; });
  std::ranges::sort(segments.touching);
  segments.touching.erase(std::unique(segments.touching.begin(), segments.touching.end()),
                          segments.touching.end());
  return {grid, std::move(in)};
}

}  // namespace estancia
