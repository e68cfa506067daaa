// SPDX-License-Identifier: Apache-2.0
#include "recognition/clutter.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <random>

#include "estancia/cloud/neighbors.hpp"
#include "estancia/cloud/normals.hpp"
#include "estancia/cloud/resolution.hpp"
#include "estancia/core/error.hpp"
#include "estancia/files/cloud_file.hpp"

namespace estancia::experiments {
namespace {

constexpr int imageWidth = 640, imageHeight = 480;
constexpr double focalLength = 525, centerX = 319.5, centerY = 239.5;

/// Gives equal numbers on every machine.
class Random {
 public:
  explicit Random(std::uint64_t seed) : bits_(seed) {}
  double between(double low, double high) {
    return low + (high - low) * static_cast<double>(bits_() >> 11U) * 0x1p-53;
  }
  std::size_t below(std::size_t count) { return static_cast<std::size_t>(bits_() % count); }
  cv::Vec3d direction() {
    const double z = between(-1, 1), turn = between(0, 2 * std::numbers::pi), r = std::sqrt(1 - z * z);
    return {r * std::cos(turn), r * std::sin(turn), z};
  }

 private:
  std::mt19937_64 bits_;
};

/// The shortest rotation that turns one unit vector into another.
cv::Matx33d turning(const cv::Vec3d& from, const cv::Vec3d& to) {
  const cv::Vec3d axis = from.cross(to);
  const double sine = cv::norm(axis);
  return sine > 0 ? cv::Affine3d(axis * (std::atan2(sine, from.dot(to)) / sine)).rotation()
                  : cv::Matx33d::eye();
}

cv::Matx33d around(const cv::Vec3d& axis, double angle) {
  return cv::Affine3d(cv::Vec3d(axis * angle)).rotation();
}

/// A model as discs that cover its surface.
struct Discs {
  std::vector<cv::Point3f> points, normals;
  double radius = 0;  // [m]
  cv::Vec3d center;
};

Discs discsOf(const PointCloud& cloud) {
  constexpr double perSpacing = 1.8, perRadius = 4;  // multiples of the points' spacing
  Discs discs;
  for (const cv::Point3f& p : cloud.points)
    if (isFinite(p)) discs.points.push_back(p);
  if (discs.points.empty())
    throw Error(ErrorCode::invalidInput, "a model without points; give clouds of objects");
  const Neighbors neighbors(discs.points);
  const double spacing = spacingOf(neighbors);
  discs.normals = estimateNormals(discs.points, neighbors, {.radius = perRadius * spacing});
  discs.radius = perSpacing * spacing;
  for (const cv::Point3f& p : discs.points) discs.center += cv::Vec3d(cv::Point3d(p));
  discs.center *= 1 / static_cast<double>(discs.points.size());
  return discs;
}

/// Depths where rays meet discs: at each pixel the mean of those near the nearest.
cv::Mat render(const Discs& discs, const cv::Affine3d& pose) {
  struct Hit {
    int pixel;
    float depth, weight;
  };
  std::vector<Hit> hits;
  const cv::Affine3f transform(pose);
  const cv::Matx33f turn = transform.rotation();
  for (std::size_t i = 0; i < discs.points.size(); ++i) {
    const cv::Point3f p = transform * discs.points[i], n = turn * discs.normals[i];
    if (!isFinite(n) || !(p.z > 0) || n.dot(p) > -0.05F * static_cast<float>(cv::norm(p))) continue;
    const double reach = focalLength * discs.radius / p.z;
    const double u = focalLength * p.x / p.z + centerX, v = focalLength * p.y / p.z + centerY;
    for (int y = std::max(0, static_cast<int>(std::ceil(v - reach)));
         y <= std::min(imageHeight - 1, static_cast<int>(std::floor(v + reach))); ++y)
      for (int x = std::max(0, static_cast<int>(std::ceil(u - reach)));
           x <= std::min(imageWidth - 1, static_cast<int>(std::floor(u + reach))); ++x) {
        const cv::Point3f ray(static_cast<float>((x - centerX) / focalLength),
                              static_cast<float>((y - centerY) / focalLength), 1);
        const float depth = n.dot(p) / n.dot(ray);
        const cv::Point3f off = ray * depth - p;
        const auto radius = static_cast<float>(discs.radius);
        const float share = off.dot(off) / (radius * radius);
        if (share < 1) hits.push_back({y * imageWidth + x, depth, 1 - share});
      }
  }
  std::stable_sort(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) {
    return a.pixel < b.pixel || (a.pixel == b.pixel && a.depth < b.depth);
  });
  cv::Mat depths = cv::Mat::zeros(imageHeight, imageWidth, CV_32F);
  for (std::size_t begin = 0; begin < hits.size();) {
    std::size_t end = begin;
    double sum = 0, weights = 0;
    const auto thickness = static_cast<float>(2 * discs.radius);
    for (; end < hits.size() && hits[end].pixel == hits[begin].pixel; ++end) {
      if (hits[end].depth > hits[begin].depth + thickness) continue;
      sum += static_cast<double>(hits[end].weight) * hits[end].depth;
      weights += static_cast<double>(hits[end].weight);
    }
    depths.at<float>(hits[begin].pixel / imageWidth, hits[begin].pixel % imageWidth) =
        static_cast<float>(sum / weights);
    begin = end;
  }
  return depths;
}

/// Seen from where the model was seen, but for a tilt, at any angle around the line of sight.
cv::Affine3d poseAt(const Discs& discs, const cv::Vec3d& place, double tilt, double tiltAxis, double roll) {
  const cv::Vec3d from = cv::normalize(discs.center), to = cv::normalize(place);
  const cv::Vec3d side = cv::normalize(to.cross(cv::Vec3d(0, 1, 0)));
  const cv::Vec3d axis = around(to, tiltAxis) * side;
  const cv::Matx33d turn = around(axis, tilt) * around(to, roll) * turning(from, to);
  return {turn, place - turn * discs.center};
}

/// Merges two depth images: the nearer wins.
void addTo(cv::Mat& scene, const cv::Mat& object) {
  for (int i = 0; i < imageWidth * imageHeight; ++i) {
    float& kept = scene.at<float>(i / imageWidth, i % imageWidth);
    const float depth = object.at<float>(i / imageWidth, i % imageWidth);
    if (depth > 0 && (kept == 0 || depth < kept)) kept = depth;
  }
}

/// Moves an object towards the middle, from outside, until its silhouette touches or overlaps what is there.
cv::Affine3d putBeside(const Discs& discs, const cv::Mat& scene, const ClutterOptions& options,
                       Random& random) {
  constexpr double outside = 0.30, step = 0.004;  // [m]
  const double distance = random.between(options.nearest, options.farthest);
  const double heading = random.between(0, 2 * std::numbers::pi);
  const double tilt = random.between(0, options.tilt) * std::numbers::pi / 180;
  const double tiltAxis = random.between(0, 2 * std::numbers::pi);
  const double roll = random.between(0, 2 * std::numbers::pi);
  const double wanted = random.between(0, options.overlap);
  const cv::Mat there = scene > 0;
  cv::Mat around;
  cv::dilate(there, around, cv::getStructuringElement(cv::MORPH_RECT, {5, 5}));
  cv::Affine3d pose;
  for (double away = cv::countNonZero(there) > 0 ? outside : 0; away >= 0; away -= step) {
    pose =
        poseAt(discs, {away * std::cos(heading), away * std::sin(heading), distance}, tilt, tiltAxis, roll);
    const cv::Mat silhouette = render(discs, pose) > 0;
    if (cv::countNonZero(silhouette & around) == 0) continue;
    const double overlap = cv::countNonZero(silhouette & there);
    if (overlap >= wanted * cv::countNonZero(silhouette)) break;
  }
  return pose;
}

}  // namespace

OptionGroup declare(ClutterOptions& options) {
  OptionGroup group("clutter", "Seeded scenes of models that touch each other, without a table.");
  group.add("scenes", &options.scenes, "Scenes to make").range(1, 100000);
  group.add("fewest", &options.fewest, "Fewest objects of a scene").range(1, 1000);
  group.add("most", &options.most, "Most objects of a scene").range(1, 1000);
  group.add("nearest", &options.nearest, "Smallest distance of an object").unit("m").range(0.1, 100);
  group.add("farthest", &options.farthest, "Largest distance of an object").unit("m").range(0.1, 100);
  group.add("tilt", &options.tilt, "Largest angle between the views of model and scene")
      .unit("degrees")
      .range(0, 180);
  group.add("overlap", &options.overlap, "Largest share of a silhouette that overlaps others").range(0, 1);
  group.add("seed", &options.seed, "Seed of the scenes");
  return group;
}

ClutterScene makeClutter(const std::vector<ClutterModel>& models, const ClutterOptions& options,
                         std::size_t number) {
  Random random(options.seed * 1'000'003 + number);
  std::map<std::string, std::vector<std::size_t>> byObject;
  for (std::size_t m = 0; m < models.size(); ++m) byObject[models[m].object].push_back(m);
  std::vector<std::string> objects;
  for (const auto& [object, its] : byObject) objects.push_back(object);
  const std::size_t most = std::min(std::max(options.fewest, options.most), objects.size());
  const std::size_t fewest = std::min(options.fewest, most);
  const std::size_t count = fewest + random.below(most - fewest + 1);
  for (std::size_t i = 0; i < count; ++i)
    std::swap(objects[i], objects[i + random.below(objects.size() - i)]);

  ClutterScene scene;
  cv::Mat depth = cv::Mat::zeros(imageHeight, imageWidth, CV_32F);
  for (std::size_t i = 0; i < count; ++i) {
    const auto& its = byObject[objects[i]];
    const std::size_t model = its[random.below(its.size())];
    const Discs discs = discsOf(models[model].cloud);
    const cv::Affine3d pose = putBeside(discs, depth, options, random);
    scene.instances.push_back({model, pose});
    addTo(depth, render(discs, pose));
  }
  const CameraIntrinsics camera{imageWidth, imageHeight, focalLength, focalLength, centerX, centerY};
  for (const cv::Point3f& p : backProject(depth, camera).points)
    if (isFinite(p)) scene.cloud.points.push_back(p);
  scene.cloud.width = scene.cloud.points.size();
  scene.cloud.height = 1;
  return scene;
}

ModelPairs withClutter(const ModelPairs& pairs, const ClutterOptions& options,
                       const std::filesystem::path& folder) {
  std::vector<ClutterModel> models;
  for (const ModelPairs::Model& model : pairs.models) models.push_back({model.object, readCloud(model.file)});
  ModelPairs made;
  made.models = pairs.models;
  std::filesystem::create_directories(folder);
  for (std::size_t s = 0; s < options.scenes; ++s) {
    const ClutterScene scene = makeClutter(models, options, s);
    const std::string name = fmt::format("clutter{:03}", s);
    const std::filesystem::path file = folder / (name + ".pcd");
    if (!std::filesystem::exists(file)) writeCloud(scene.cloud, file);
    made.scenes.push_back({name, file});
    for (const ClutterScene::Instance& instance : scene.instances)
      made.pairs.push_back({s, instance.model, {instance.pose}});
  }
  return made;
}

cv::Affine3d randomFrame(std::uint64_t seed) {
  Random random(seed);
  const double angle = random.between(0, std::numbers::pi);
  const cv::Vec3d axis = random.direction(), shift = random.direction() * random.between(0.5, 3);
  return {around(axis, angle), shift};
}

}  // namespace estancia::experiments
