// SPDX-License-Identifier: Apache-2.0
#include "objects/object_segmentation_score.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <opencv2/core.hpp>
#include <utility>

#include "estancia/cloud/neighbors.hpp"
#include "estancia/core/error.hpp"

namespace estancia::experiments {
namespace {

constexpr double half = 0.5, fifth = 0.2;

void requireTruth(const cv::Mat& truth) {
  if (truth.type() != CV_32SC1 || !truth.isContinuous())
    throw Error(ErrorCode::invalidInput, "the objects of an image must be one image of 32-bit numbers");
}

/// Sets that grow together.
class Partition {
 public:
  explicit Partition(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), std::uint32_t{0});
  }
  std::uint32_t find(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = find(a), b = find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

bool onPlane(const cv::Point3f& p, const std::vector<Plane>& planes, double tolerance) {
  const double most = tolerance * std::max(1.0, static_cast<double>(p.z) * p.z);
  return std::any_of(planes.begin(), planes.end(), [&](const Plane& plane) {
    return std::abs(plane.normal.dot({p.x, p.y, p.z}) - plane.offset) <= most;
  });
}

}  // namespace

SegmentationScore scoreClusters(const cv::Mat& truth, const std::vector<PixelSet>& clusters) {
  requireTruth(truth);
  const auto* object = truth.ptr<int>();
  std::map<int, std::size_t> sizes;
  for (std::size_t i = 0; i < truth.total(); ++i)
    if (object[i] != 0) ++sizes[object[i]];

  struct Held {
    double best = 0;
    std::size_t parts = 0;
    bool shares = false;
  };
  std::map<int, Held> held;
  for (const PixelSet& cluster : clusters) {
    std::map<int, std::size_t> common;
    for (const std::uint32_t pixel : cluster) {
      if (pixel >= truth.total())
        throw Error(ErrorCode::invalidInput,
                    fmt::format("a cluster has the pixel {} of an image of {}", pixel, truth.total()));
      if (object[pixel] != 0) ++common[object[pixel]];
    }
    std::vector<int> holds;
    for (const auto& [o, pixels] : common) {
      const auto shared = static_cast<double>(pixels), size = static_cast<double>(sizes[o]);
      held[o].best = std::max(held[o].best, shared / (size + static_cast<double>(cluster.size()) - shared));
      if (shared >= fifth * size) holds.push_back(o);
    }
    for (const int o : holds) {
      ++held[o].parts;
      held[o].shares |= holds.size() > 1;
    }
  }
  SegmentationScore score;
  score.objects = sizes.size();
  for (const auto& [o, what] : held) {
    score.found += what.best >= half;
    score.over += what.parts > 1;
    score.under += what.shares;
    score.iou += what.best;
  }
  return score;
}

cv::Mat whereDepthIs(const cv::Mat& truth, const cv::Mat& depth) {
  if (truth.size() != depth.size())
    throw Error(ErrorCode::mismatch,
                fmt::format("the objects are marked on {}×{} pixels, but depth has {}×{}", truth.cols,
                            truth.rows, depth.cols, depth.rows));
  cv::Mat known = truth.clone();
  known.setTo(0, ~(depth > 0));  // NaN is not
  return known;
}

std::vector<PixelSet> objectsOf(const cv::Mat& truth) {
  requireTruth(truth);
  std::map<int, PixelSet> objects;
  for (std::uint32_t i = 0; i < truth.total(); ++i)
    if (const int object = truth.ptr<int>()[i]; object != 0) objects[object].push_back(i);
  std::vector<PixelSet> all;
  all.reserve(objects.size());
  for (auto& [object, pixels] : objects) all.push_back(std::move(pixels));
  return all;
}

std::vector<PixelSet> euclideanClusters(const cv::Mat& depth, const CameraIntrinsics& camera,
                                        const std::vector<Plane>& planes, const ClusterOptions& options,
                                        double tolerance) {
  // Equally dense at any resolution; at 525 pixels of focal length every third.
  const double focal = camera.scaledTo(depth.cols, depth.rows).fx, scale = focal / 525;
  const int step = std::max(1, static_cast<int>(std::lround(3 * scale)));
  const PointCloud cloud = backProject(depth, camera);
  const auto wanted = [&](std::size_t i) {
    return isFinite(cloud.points[i]) && !onPlane(cloud.points[i], planes, options.planeTolerance);
  };
  const auto at = [&](int row, int column) { return static_cast<std::uint32_t>(row * depth.cols + column); };
  // The middle of each block stands for it.
  std::vector<cv::Point3f> points;
  std::vector<cv::Point> blocks;
  for (int r = step / 2; r < depth.rows; r += step)
    for (int c = step / 2; c < depth.cols; c += step)
      if (wanted(at(r, c))) {
        points.push_back(cloud.points[at(r, c)]);
        blocks.emplace_back(c - step / 2, r - step / 2);
      }
  const Neighbors tree(points);
  Partition partition(points.size());
  std::vector<Neighbor> buffer;
  for (std::uint32_t i = 0; i < points.size(); ++i)
    for (const Neighbor& other : tree.within(points[i], static_cast<float>(tolerance), buffer))
      partition.join(i, other.index);
  std::map<std::uint32_t, PixelSet> clusters;
  for (std::uint32_t i = 0; i < points.size(); ++i)
    for (int r = blocks[i].y; r < std::min(blocks[i].y + step, depth.rows); ++r)
      for (int c = blocks[i].x; c < std::min(blocks[i].x + step, depth.cols); ++c)
        if (wanted(at(r, c))) clusters[partition.find(i)].push_back(at(r, c));
  std::vector<PixelSet> all;
  for (auto& [first, pixels] : clusters)
    if (static_cast<double>(pixels.size()) >= static_cast<double>(options.minPoints) * scale * scale) {
      std::sort(pixels.begin(), pixels.end());
      all.push_back(std::move(pixels));
    }
  return all;
}

PointCloud posterOf(const PointCloud& cloud, const PixelSet& object, std::uint64_t seed) {
  constexpr double noise = 0.0014, step = 0.00285;  // [m at 1 m]
  cv::Vec3d center(0, 0, 0);
  for (const std::uint32_t i : object)
    center += cv::Vec3d(cloud.points.at(i).x, cloud.points[i].y, cloud.points[i].z);
  center /= static_cast<double>(std::max<std::size_t>(object.size(), 1));
  cv::RNG random(seed);
  PointCloud poster = pointsOf(cloud, object);
  poster.normals.clear();
  for (cv::Point3f& p : poster.points) {
    const cv::Vec3d ray(p.x / p.z, p.y / p.z, 1);
    const double z = center.dot(center) / center.dot(ray), steps = step * z * z;
    const double seen = std::round((z + random.gaussian(noise * z * z)) / steps) * steps;
    p = {static_cast<float>(ray[0] * seen), static_cast<float>(ray[1] * seen), static_cast<float>(seen)};
  }
  return poster;
}

}  // namespace estancia::experiments
