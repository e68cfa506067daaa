// SPDX-License-Identifier: Apache-2.0
#include "estancia/segmentation/segmentation_stages.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <opencv2/core.hpp>
#include <optional>

#include "estancia/cloud/bounds.hpp"
#include "estancia/cloud/neighbors.hpp"
#include "estancia/cloud/normals.hpp"
#include "estancia/cloud/resolution.hpp"
#include "estancia/cloud/voxel_grid.hpp"
#include "estancia/segmentation/segments.hpp"

namespace estancia {
namespace {

constexpr double minLeaf = 0.005;                       // [m]
constexpr float maxCoordinate = 1e9F;                   // [m]: squares stay far below the largest float
constexpr float linkDistance = 3, nextDistance = 1.8F;  // edges of a voxel
constexpr std::size_t aroundNormal = 30;                // points
constexpr std::uint32_t noSegment = 0;                  // no segment

/// One point a voxel.
struct Surface {
  PointCloud cloud;
  std::vector<cv::Point3f> normals;
  std::vector<double> noise;  ///< relative to that at 1 m
  Neighbors neighbors;
  double leaf;
  float link;     ///< distance of connected points [m]
  float next;     ///< distance of points in neighboring voxels [m]
  bool oriented;  ///< normals point towards the sensor
  std::size_t size() const { return cloud.points.size(); }
};

bool isOutOfRange(const cv::Point3f& p) {
  return isFinite(p) && std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) > maxCoordinate;
}

Surface surfaceOf(const PointCloud& cloud, int threads) {
  const double leaf = std::max(2 * resolutionOf(cloud), minLeaf);
  PointCloud thin = voxelGrid(cloud, leaf);
  Neighbors neighbors(thin.points, threads);
  NormalOptions options;
  options.neighbors = aroundNormal;
  options.threads = threads;
  if (cloud.viewpoint)
    options.viewpoint = cv::Point3d(cloud.viewpoint->x, cloud.viewpoint->y, cloud.viewpoint->z);
  std::vector<cv::Point3f> normals = estimateNormals(thin.points, neighbors, options);
  for (std::size_t i = 0; i < thin.normals.size(); ++i)  // given normals decide which side is visible
    if (thin.normals[i].dot(normals[i]) < 0) normals[i] = -normals[i];
  std::vector<double> noise;
  noise.reserve(thin.points.size());
  for (const cv::Point3f& p : thin.points) {
    const cv::Point3d d = p - options.viewpoint;
    noise.push_back(std::max(1., d.dot(d)));
  }
  const bool oriented = !thin.normals.empty() || cloud.viewpoint.has_value() ||
                        !boundsOf(thin.points).contains(options.viewpoint);
  const auto length = static_cast<float>(leaf);
  return {.cloud = std::move(thin),
          .normals = std::move(normals),
          .noise = std::move(noise),
          .neighbors = std::move(neighbors),
          .leaf = leaf,
          .link = linkDistance * length,
          .next = nextDistance * length,
          .oriented = oriented};
}

/// Connected components of the points without a label that are `wanted`, labeled from sizes.size() on.
/// Components of less than `minPoints` points stay without a label.
template <class Wanted>
void labelConnected(const Surface& s, const Wanted& wanted, double minPoints,
                    std::vector<std::uint32_t>& labels, std::vector<std::uint32_t>& sizes) {
  std::vector<std::uint32_t> group;
  std::vector<std::uint8_t> seen(s.size());
  std::vector<Neighbor> buffer;
  for (std::uint32_t first = 0; first < s.size(); ++first) {
    if (!wanted(first) || labels[first] != noSegment || seen[first] != 0) continue;
    group.assign(1, first);
    seen[first] = 1;
    for (std::size_t k = 0; k < group.size(); ++k)
      for (const Neighbor& n : s.neighbors.within(s.cloud.points[group[k]], s.link, buffer)) {
        if (!wanted(n.index) || labels[n.index] != noSegment || seen[n.index] != 0) continue;
        seen[n.index] = 1;
        group.push_back(n.index);
      }
    if (static_cast<double>(group.size()) < minPoints) continue;
    for (const std::uint32_t i : group) labels[i] = static_cast<std::uint32_t>(sizes.size());
    sizes.push_back(static_cast<std::uint32_t>(group.size()));
  }
}

/// RANSAC with one point and its normal a hypothesis: the plane with most of the sampled candidates on it.
std::optional<PlaneFit> bestPlane(const Surface& s, const std::vector<std::uint32_t>& candidates,
                                  double tolerance, cv::RNG& random) {
  constexpr int hypotheses = 150, maxSamples = 3000;
  constexpr double faces = 0.94;
  const auto any = [&] {
    return candidates[static_cast<std::size_t>(random.uniform(0, static_cast<int>(candidates.size())))];
  };
  std::vector<std::uint32_t> samples;
  samples.reserve(maxSamples);
  for (int i = 0; i < maxSamples; ++i) samples.push_back(any());
  const auto isOn = [&](const PlaneFit& plane, std::uint32_t i) {
    const cv::Point3f& n = s.normals[i];
    return std::abs(plane.distance(s.cloud.points[i])) < tolerance * s.noise[i] &&
           std::abs(plane.normal.dot(cv::Vec3d(n.x, n.y, n.z))) > faces;
  };
  std::optional<PlaneFit> best;
  std::ptrdiff_t maxVotes = 0;
  for (int h = 0; h < hypotheses; ++h) {
    const std::uint32_t i = any();
    const cv::Point3f &p = s.cloud.points[i], &n = s.normals[i];
    const PlaneFit plane{{p.x, p.y, p.z}, {n.x, n.y, n.z}};
    const auto votes = std::ranges::count_if(samples, [&](std::uint32_t k) { return isOn(plane, k); });
    if (votes > maxVotes) std::tie(maxVotes, best) = std::tuple(votes, plane);
  }
  for (int round = 0; round < 3 && best; ++round) {
    std::vector<cv::Point3f> on;
    for (const std::uint32_t k : samples)
      if (isOn(*best, k)) on.push_back(s.cloud.points[k]);
    const auto fitted = fitPlane(on);
    if (!fitted) break;
    best = fitted;
  }
  return best;
}

/// Clears the points of planes in `rest`.
std::vector<Plane> removePlanes(const Surface& s, const ClusterOptions& options,
                                std::vector<std::uint8_t>& rest) {
  constexpr int maxTries = 16;
  constexpr std::size_t maxPlanes = 8;
  constexpr double facesLoosely = 0.9;
  std::vector<Plane> planes;
  std::vector<std::uint8_t> left(s.size());
  for (std::size_t i = 0; i < s.size(); ++i) left[i] = isFinite(s.normals[i]);
  cv::RNG random(options.seed);
  for (int t = 0; t < maxTries && planes.size() < maxPlanes; ++t) {
    std::vector<std::uint32_t> candidates;
    for (std::uint32_t i = 0; i < s.size(); ++i)
      if (left[i] != 0) candidates.push_back(i);
    if (candidates.empty()) break;
    const auto plane = bestPlane(s, candidates, options.planeTolerance, random);
    if (!plane) break;
    const auto isNear = [&](std::uint32_t i) {
      return std::abs(plane->distance(s.cloud.points[i])) < options.planeTolerance * s.noise[i];
    };
    std::vector<std::uint8_t> on(s.size());
    for (const std::uint32_t i : candidates) {
      const cv::Point3f& n = s.normals[i];
      on[i] = isNear(i) && std::abs(plane->normal.dot(cv::Vec3d(n.x, n.y, n.z))) > facesLoosely;
    }
    // The number of voxels that a plane intersects, for a square of their edge.
    const double voxels =
        std::abs(plane->normal[0]) + std::abs(plane->normal[1]) + std::abs(plane->normal[2]);
    const double pointArea = s.leaf * s.leaf / voxels;
    std::vector<std::uint32_t> labels(s.size()), sizes(1);
    labelConnected(
        s, [&](std::uint32_t i) { return on[i] != 0; }, options.minPlaneArea / 2 / pointArea, labels, sizes);
    bool any = false;
    for (const std::uint32_t i : candidates) {
      any = any || on[i] != 0;
      if (on[i] != 0) left[i] = 0;  // a plane that is too small is skipped: others may remain
    }
    if (!any) break;
    if (std::ranges::max(sizes) * pointArea < options.minPlaneArea) continue;
    std::vector<Neighbor> buffer;
    double area = 0;
    for (const std::uint32_t i : candidates) {
      if (labels[i] == noSegment) continue;
      area += pointArea;
      for (const Neighbor& n : s.neighbors.within(s.cloud.points[i], s.link, buffer))
        if (isNear(n.index)) rest[n.index] = left[n.index] = 0;
    }
    const double side = plane->normal.dot(plane->center) > 0 && s.oriented ? -1 : 1;
    planes.push_back({side * plane->normal, side * plane->normal.dot(plane->center), area});
  }
  return planes;
}

/// Points around which the surface rises towards the sensor. The mean over a disc is about 0.6 of the rise at
/// the same distance perpendicular to the crease, which is what `depth` means.
std::vector<std::uint8_t> creasesOf(const Surface& s, const std::vector<std::uint8_t>& rest, double depth,
                                    int threads) {
  constexpr double disc = 0.6;
  std::vector<std::uint8_t> creases(s.size());
  if (!s.oriented) return creases;
  s.neighbors.eachWithin(s.link, threads, [&](std::uint32_t i, std::span<const Neighbor> near) {
    if (rest[i] == 0 || !isFinite(s.normals[i])) return;
    double rise = 0, count = 0;
    for (const Neighbor& n : near) {
      if (n.index == i) continue;
      rise += (s.cloud.points[n.index] - s.cloud.points[i]).dot(s.normals[i]);
      ++count;
    }
    creases[i] = rise > disc * depth * s.noise[i] * count;
  });
  return creases;
}

/// Dilation: every point within `radius` of a marked one.
std::vector<std::uint8_t> dilated(const Surface& s, const std::vector<std::uint8_t>& marked, float radius) {
  std::vector<std::uint8_t> wide(s.size());
  std::vector<Neighbor> buffer;
  for (std::uint32_t i = 0; i < s.size(); ++i) {
    if (marked[i] == 0) continue;
    for (const Neighbor& n : s.neighbors.within(s.cloud.points[i], radius, buffer)) wide[n.index] = 1;
  }
  return wide;
}

/// Region growing: all segments take the points around them at the same pace.
void grow(const Surface& s, const std::vector<std::uint8_t>& rest, std::vector<std::uint32_t>& labels,
          std::vector<std::uint32_t>& sizes) {
  std::vector<std::uint32_t> front;
  std::vector<Neighbor> buffer;
  for (std::uint32_t i = 0; i < s.size(); ++i)
    if (labels[i] != noSegment) front.push_back(i);
  for (std::size_t k = 0; k < front.size(); ++k)
    for (const Neighbor& n : s.neighbors.within(s.cloud.points[front[k]], s.next, buffer)) {
      if (rest[n.index] == 0 || labels[n.index] != noSegment) continue;
      labels[n.index] = labels[front[k]];
      ++sizes[labels[front[k]]];
      front.push_back(n.index);
    }
}

std::vector<SegmentBorder> bordersBetween(const Surface& s, const std::vector<std::uint32_t>& labels,
                                          const std::vector<std::uint8_t>& creases) {
  std::vector<std::uint64_t> pairs;
  std::vector<Neighbor> buffer;
  for (std::uint32_t i = 0; i < s.size(); ++i) {
    if (labels[i] == noSegment) continue;
    for (const Neighbor& n : s.neighbors.within(s.cloud.points[i], s.next, buffer))
      if (n.index > i && labels[n.index] != noSegment && labels[n.index] != labels[i])
        pairs.push_back(pairOf(labels[i], labels[n.index], (creases[i] | creases[n.index]) != 0));
  }
  return bordersOf(std::move(pairs));
}

/// Fills in all members but the points, and sorts.
void finish(const PointCloud& cloud, const ClusterOptions& options, std::vector<Cluster>& clusters) {
  std::erase_if(clusters, [&](const Cluster& c) {
    return c.points.size() < std::max<std::size_t>(1, options.minPoints);
  });
  std::ranges::stable_sort(clusters, std::ranges::greater{},
                           [](const Cluster& c) { return c.points.size(); });
  for (Cluster& cluster : clusters) {
    cv::Point3d sum;
    for (const std::uint32_t i : cluster.points) sum += cv::Point3d(cloud.points[i]);
    cluster.center = sum / static_cast<double>(cluster.points.size());
    cluster.flat = isFlat(pointsOf(cloud, cluster.points));
  }
}

}  // namespace

Clusters findUnorganizedClusters(const PointCloud& cloud, const ClusterOptions& options) {
  constexpr double minSeed = 8, minSegment = 30;  // points of the surface
  if (std::ranges::any_of(cloud.points, isOutOfRange)) {
    constexpr float none = std::numeric_limits<float>::quiet_NaN();
    PointCloud rest = cloud;
    std::ranges::replace_if(rest.points, isOutOfRange, cv::Point3f(none, none, none));
    return findUnorganizedClusters(rest, options);
  }
  const Surface s = surfaceOf(cloud, options.threads);
  Clusters result;
  std::vector<std::uint8_t> rest(s.size(), 1);
  result.planes = removePlanes(s, options, rest);
  const std::vector<std::uint8_t> creases = creasesOf(s, rest, options.creaseDepth, options.threads);
  const std::vector<std::uint8_t> nearCrease = dilated(s, creases, s.link);
  std::vector<std::uint32_t> labels(s.size()), sizes(1);
  labelConnected(
      s, [&](std::uint32_t i) { return rest[i] > nearCrease[i]; }, minSeed, labels, sizes);
  grow(s, rest, labels, sizes);
  labelConnected(
      s, [&](std::uint32_t i) { return rest[i] != 0; }, 1, labels, sizes);
  std::vector<SegmentBorder> borders = bordersBetween(s, labels, creases);
  DisjointSets sets(sizes.size());
  mergeNeighbors(borders, sets, sizes, minSegment);
  std::vector<Cluster> clusters(sizes.size());
  std::vector<Neighbor> buffer;
  for (std::uint32_t i = 0; i < cloud.points.size(); ++i) {
    if (!isMeasured(cloud.points[i])) continue;
    const auto nearest = s.neighbors.nearest(cloud.points[i], 1, buffer);
    const std::uint32_t label = labels[nearest.front().index];
    if (label != noSegment) clusters[sets.find(label)].points.push_back(i);
  }
  finish(cloud, options, clusters);
  result.clusters = std::move(clusters);
  return result;
}

}  // namespace estancia
