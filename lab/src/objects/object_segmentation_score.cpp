// SPDX-License-Identifier: Apache-2.0
#include "objects/object_segmentation_score.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/core.hpp>
#include <utility>

#include "estancia/core/error.hpp"

namespace estancia::experiments {
namespace {

constexpr double half = 0.5, fifth = 0.2;

void requireTruth(const cv::Mat& truth) {
  if (truth.type() != CV_32SC1 || !truth.isContinuous())
    throw Error(ErrorCode::invalidInput, "the objects of an image must be one image of 32-bit numbers");
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
