// SPDX-License-Identifier: Apache-2.0
#include "estancia/segmentation/segmentation_stages.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <tuple>

#include "estancia/cloud/bounds.hpp"
#include "estancia/cloud/normals.hpp"
#include "estancia/core/cores.hpp"
#include "estancia/core/parallel.hpp"
#include "estancia/core/simd.hpp"

namespace estancia {
namespace {

// Images may have thousands of segments, and segments are compared in pairs: this bounds the work. A kitchen
// has about 50 segments.
constexpr std::size_t maxSegmentSamples = 512;
constexpr double minSampledArea = 100;                     // [square pixels]
constexpr std::size_t maxSurface = 1500, maxBorder = 256;  // points of a segment

void thin(std::vector<cv::Point3f>& points, std::size_t max) {
  if (points.size() <= max) return;
  for (std::size_t i = 0; i < max; ++i) points[i] = points[i * points.size() / max];
  points.resize(max);
}

/// Segments that are large enough, at most maxSegmentSamples of them; ascending.
std::vector<std::uint32_t> largeSegments(const Segmentation& segments, double minPixels) {
  std::vector<std::uint32_t> large;
  for (std::uint32_t i = 1; i < segments.sizes.size(); ++i)
    if (segments.sizes[i] >= minPixels) large.push_back(i);
  if (large.size() <= maxSegmentSamples) return large;
  std::ranges::nth_element(large, large.begin() + maxSegmentSamples, [&](std::uint32_t a, std::uint32_t b) {
    return std::tuple(segments.sizes[b], a) < std::tuple(segments.sizes[a], b);
  });
  large.resize(maxSegmentSamples);
  std::ranges::sort(large);
  return large;
}

constexpr std::size_t maxPairs = 4096;  // compared at most; a kitchen has about 100
constexpr double split = 4;             // width of a gap of mixed pixels: two at either edge [pixels]
constexpr float fartherApart = 0.05F;   // [m]: the other point of a contact is no farther
constexpr std::size_t minContacts = 3;  // points of the border that must be near
constexpr double concave = -0.2;        // how concave a contact may be
constexpr float aroundContact = 0.03F;  // [m]
constexpr double maxGap = 0.20;         // behind an occluder [m]
constexpr float aroundGap = 0.05F;      // the part of either side that is compared [m]
constexpr double maxTurn = 20, maxOffset = 0.025;  // limits for two parts of one surface [°], [m]
constexpr double hidden = 0.9, inFront = 0.3;      // shares of the gap
constexpr float minNearer = 0.01F;                 // distance of the occluder to the gap [m]

float squared(const cv::Point3f& v) {
  return v.dot(v);
}

/// The squared distance to the nearest of some points, as the bits of the float: those of floats that are not
/// negative order as they do.
ESTANCIA_MULTIVERSION
std::int32_t nearestOf(const float* x, const float* y, const float* z, std::size_t count, float px, float py,
                       float pz) {
  std::int32_t smallest = std::numeric_limits<std::int32_t>::max();
  for (std::size_t i = 0; i < count; ++i) {
    const float dx = x[i] - px, dy = y[i] - py, dz = z[i] - pz;
    smallest = std::min(smallest, std::bit_cast<std::int32_t>(dx * dx + dy * dy + dz * dz));
  }
  return smallest;
}

/// The first of those at that distance.
ESTANCIA_MULTIVERSION
std::int32_t firstAt(std::int32_t smallest, const float* x, const float* y, const float* z,
                     std::int32_t count, float px, float py, float pz) {
  std::int32_t first = count - 1;
  for (std::int32_t i = 0; i < count; ++i) {
    const float dx = x[i] - px, dy = y[i] - py, dz = z[i] - pz;
    const bool equal = std::bit_cast<std::int32_t>(dx * dx + dy * dy + dz * dz) == smallest;
    first = std::min(first, equal ? i : count);
  }
  return first;
}

/// The points of the one within `radius` of a point of the other.
std::vector<cv::Point3f> near(std::span<const cv::Point3f> points, std::span<const cv::Point3f> others,
                              float radius) {
  std::vector<cv::Point3f> result;
  if (others.empty()) return result;
  Bounds<float> box = boundsOf(others);
  const cv::Point3f reach(radius, radius, radius);
  box.low -= reach;
  box.high += reach;
  const cv::Point3f* last = others.data();  // the next point is often near the same one
  for (const cv::Point3f& p : points) {
    if (!box.contains(p)) continue;
    const auto isNear = [&](const cv::Point3f& q) { return squared(p - q) < radius * radius; };
    if (!isNear(*last)) {
      const auto found = std::ranges::find_if(others, isNear);
      if (found == others.end()) continue;
      last = &*found;
    }
    result.push_back(p);
  }
  return result;
}

/// The plane of the visible part of a surface, oriented towards the camera.
std::optional<PlaneFit> visiblePlane(std::span<const cv::Point3f> points, std::size_t minPoints) {
  auto plane = fitPlane(points, minPoints);
  if (plane && plane->normal.dot(plane->center) > 0) plane->normal = -plane->normal;
  return plane;
}

/// Whether the surfaces meet flat or convexly where they touch (Stein et al., CVPR 2014, equation 4).
bool meetConvexly(const SegmentSamples& a, const SegmentSamples& b, std::span<const cv::Point3f> contactA,
                  std::span<const cv::Point3f> contactB) {
  constexpr float reach = 2 * aroundContact;
  const auto atA = visiblePlane(
      near(near(a.surface, contactB, reach), near(b.surface, contactA, reach), aroundContact), 3);
  const auto atB = visiblePlane(
      near(near(b.surface, contactA, reach), near(a.surface, contactB, reach), aroundContact), 3);
  if (!atA || !atB) return true;  // too small to decide
  const cv::Vec3d between = atA->center - atB->center;
  const double length = cv::norm(between);
  return length == 0 || (atA->normal - atB->normal).dot(between) > concave * length;
}

cv::Point2d pixelOf(const CameraIntrinsics& camera, const cv::Point3f& p) {
  return {camera.fx * p.x / p.z + camera.cx, camera.fy * p.y / p.z + camera.cy};
}

/// Whether an occluder hides the gap between two points of these segments.
bool isHidden(const InverseDepth& grid, const Segmentation& segments, const SegmentSamples& a,
              const SegmentSamples& b, const cv::Point3f& from, const cv::Point3f& to) {
  constexpr int steps = 39;
  int covered = 0, front = 0;
  for (int i = 1; i < steps; ++i) {
    const cv::Point3f p = from + (to - from) * (static_cast<float>(i) / steps);
    const cv::Point2d pixel = pixelOf(grid.camera, p);
    const int u = static_cast<int>(std::lround(pixel.x)), v = static_cast<int>(std::lround(pixel.y));
    const std::size_t at =
        grid.at(std::clamp(u, 0, grid.camera.width - 1), std::clamp(v, 0, grid.camera.height - 1));
    const float w = grid.raw[at];
    const bool nearer = w > 0 && 1 / w < p.z - minNearer;
    const bool own = segments.labels[at] == a.segment || segments.labels[at] == b.segment;
    front += nearer ? 1 : 0;
    covered += nearer || own || w == 0 ? 1 : 0;
  }
  return covered > hidden * (steps - 1) && front > inFront * (steps - 1);
}

/// Whether two ends lie on one surface.
bool areCoplanar(const SegmentSamples& a, const SegmentSamples& b, const cv::Point3f& endA,
                 const cv::Point3f& endB) {
  constexpr std::size_t minPoints = 15;
  const auto atA = visiblePlane(near(a.surface, {&endA, 1}, aroundGap), minPoints);
  const auto atB = visiblePlane(near(b.surface, {&endB, 1}, aroundGap), minPoints);
  if (!atA || !atB) return false;
  const cv::Vec3d between = atB->center - atA->center;
  const double off = std::max(std::abs(between.dot(atA->normal)), std::abs(between.dot(atB->normal)));
  return off < maxOffset && atA->normal.dot(atB->normal) > std::cos(maxTurn * CV_PI / 180);
}

/// Distance at which two points may touch, within the camera's accuracy [m]: a gap as narrow as its mixed
/// pixels, and the noise of depth.
double contactAt(const InverseDepth& grid, double pixels, double z) {
  return std::hypot(pixels * z / grid.camera.fx, differenceNoise * std::max(z, z * z));
}

/// Whether the camera sees past two points of different segments, between them: then they do not touch.
bool isSeenThrough(const InverseDepth& grid, const cv::Point3f& from, const cv::Point3f& to) {
  const cv::Point2d a = pixelOf(grid.camera, from), b = pixelOf(grid.camera, to);
  const int steps = static_cast<int>(std::ceil(std::max(std::abs(b.x - a.x), std::abs(b.y - a.y))));
  for (int i = 1; i < steps; ++i) {
    const double part = static_cast<double>(i) / steps;
    const cv::Point2d at = a + part * (b - a);
    const float w =
        grid.raw[grid.at(static_cast<int>(std::lround(at.x)), static_cast<int>(std::lround(at.y)))];
    const double z = from.z + part * (to.z - from.z);
    if (w > 0 && 1 / w > z + differenceNoise * std::max(z, z * z)) return true;
  }
  return false;
}

bool areInContact(const InverseDepth& grid, const cv::Point3f& a, const cv::Point3f& b) {
  const double z = std::max(a.z, b.z), gap = cv::norm(pixelOf(grid.camera, a) - pixelOf(grid.camera, b));
  return gap <= split * grid.scale + 1 && cv::norm(a - b) <= contactAt(grid, gap, z) &&
         !isSeenThrough(grid, a, b);
}

bool areOneObject(const InverseDepth& grid, const Segmentation& segments, const SegmentSamples& a,
                  const SegmentSamples& b) {
  std::vector<cv::Point3f> contactA, contactB;
  float nearest = std::numeric_limits<float>::infinity();
  cv::Point3f endA, endB;
  for (const cv::Point3f& p : b.border) {
    const std::int32_t bits = nearestOf(a.x.data(), a.y.data(), a.z.data(), a.x.size(), p.x, p.y, p.z);
    const auto smallest = std::bit_cast<float>(bits);
    const double contact = contactAt(grid, split * grid.scale + 1, p.z + fartherApart);
    const auto close = static_cast<float>(contact * contact);
    if (!(smallest < std::max(close, nearest))) continue;
    const auto count = static_cast<std::int32_t>(a.x.size());
    const std::int32_t at = firstAt(bits, a.x.data(), a.y.data(), a.z.data(), count, p.x, p.y, p.z);
    const cv::Point3f& other = a.border[static_cast<std::size_t>(at)];
    if (smallest < close && areInContact(grid, p, other)) {
      contactB.push_back(p);
      contactA.push_back(other);
    }
    if (smallest < nearest) std::tie(nearest, endA, endB) = std::tuple(smallest, other, p);
  }
  if (contactB.size() >= minContacts) return meetConvexly(a, b, contactA, contactB);
  return nearest <= maxGap * maxGap && isHidden(grid, segments, a, b, endB, endA) &&
         areCoplanar(a, b, endA, endB);
}

/// The distance between two boxes [m].
double distanceOf(const Bounds<float>& a, const Bounds<float>& b) {
  const auto apart = [](float lowA, float highA, float lowB, float highB) {
    return std::max({0.F, lowB - highA, lowA - highB});
  };
  return cv::norm(cv::Point3f(apart(a.low.x, a.high.x, b.low.x, b.high.x),
                              apart(a.low.y, a.high.y, b.low.y, b.high.y),
                              apart(a.low.z, a.high.z, b.low.z, b.high.z)));
}

/// Pairs of indices of samples whose bounding boxes come within `maxGap` of each other, but that are not
/// adjacent in the image; of more than maxPairs those whose boxes are nearest.
std::vector<std::pair<std::uint32_t, std::uint32_t>> nearPairs(const std::vector<SegmentSamples>& samples,
                                                               const Segmentation& segments) {
  std::vector<std::tuple<double, std::uint32_t, std::uint32_t>> found;
  for (std::uint32_t i = 0; i < samples.size(); ++i)
    for (std::uint32_t j = i + 1; j < samples.size(); ++j) {
      const double distance = distanceOf(samples[i].box, samples[j].box);
      if (distance <= maxGap &&
          !std::ranges::binary_search(segments.touching, std::pair(samples[i].segment, samples[j].segment)))
        found.emplace_back(distance, i, j);
    }
  if (found.size() > maxPairs) {
    std::ranges::nth_element(found, found.begin() + maxPairs);
    found.resize(maxPairs);
  }
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  pairs.reserve(found.size());
  for (const auto& [distance, i, j] : found) pairs.emplace_back(i, j);
  return pairs;
}

}  // namespace

std::vector<SegmentSamples> sampleSegments(const InverseDepth& grid, const Mask& mask,
                                           const Segmentation& segments) {
  std::vector<SegmentSamples> samples;
  std::vector<std::uint32_t> sampleOf(segments.sizes.size()), skip(segments.sizes.size());
  for (const std::uint32_t i : largeSegments(segments, grid.area(minSampledArea))) {
    samples.emplace_back().segment = i;
    sampleOf[i] = static_cast<std::uint32_t>(samples.size());
  }
  const auto stride = static_cast<std::size_t>(grid.stride);
  mask.eachPixel([&](std::size_t i) {
    const std::uint32_t label = segments.labels[i];
    if (sampleOf[label] == 0) return;
    SegmentSamples& segment = samples[sampleOf[label] - 1];
    if (skip[label]-- == 0) {
      skip[label] = segments.sizes[label] / maxSurface;
      segment.surface.push_back(grid.point(i));
    }
    if (segments.labels[i - 1] != label || segments.labels[i + 1] != label ||
        segments.labels[i - stride] != label || segments.labels[i + stride] != label)
      segment.border.push_back(grid.point(i));
  });
  for (SegmentSamples& segment : samples) {
    thin(segment.border, maxBorder);
    for (const cv::Point3f& p : segment.border) {
      segment.x.push_back(p.x);
      segment.y.push_back(p.y);
      segment.z.push_back(p.z);
      segment.box.add(p);
    }
  }
  return samples;
}

void mergePairs(std::size_t count, const FindPairs& find, const Mask& mask, int threads,
                Segmentation& segments) {
  std::vector<std::vector<std::pair<std::uint32_t, std::uint32_t>>> found(count);
  inParallel(count, static_cast<std::size_t>(threads > 0 ? threads : usableCores()),
             [&](std::size_t i) { found[i] = find(i); });
  DisjointSets sets(segments.sizes.size());
  for (const auto& pairs : found)
    for (const auto& [a, b] : pairs) sets.join(a, b);
  renumber(mask, segments, sets);
}

void mergeSegments(const InverseDepth& grid, const Mask& mask, int threads, Segmentation& segments) {
  const std::vector<SegmentSamples> samples = sampleSegments(grid, mask, segments);
  const auto pairs = nearPairs(samples, segments);
  const auto find = [&](std::size_t i) -> std::vector<std::pair<std::uint32_t, std::uint32_t>> {
    const SegmentSamples &a = samples[pairs[i].first], &b = samples[pairs[i].second];
    if (!areOneObject(grid, segments, a, b)) return {};
    return {{a.segment, b.segment}};
  };
  mergePairs(pairs.size(), find, mask, threads, segments);
}

}  // namespace estancia
