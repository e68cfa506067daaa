// SPDX-License-Identifier: Apache-2.0
#include "recognition/clutter.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "estancia/files/cloud_file.hpp"
#include "recognition/depth_rendering.hpp"
#include "recognition/seeded.hpp"

namespace estancia::experiments {
namespace {

constexpr int imageWidth = 640, imageHeight = 480;
constexpr CameraIntrinsics kinect{imageWidth, imageHeight, 525, 525, 319.5, 239.5};

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
                       Seeded& random) {
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
    const cv::Mat silhouette = rendered(discs, pose, kinect) > 0;
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
  Seeded random(options.seed * 1'000'003 + number);
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
    addTo(depth, rendered(discs, pose, kinect));
  }
  for (const cv::Point3f& p : backProject(depth, kinect).points)
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
  Seeded random(seed);
  const double angle = random.between(0, std::numbers::pi);
  const cv::Vec3d axis = random.direction(), shift = random.direction() * random.between(0.5, 3);
  return {around(axis, angle), shift};
}

}  // namespace estancia::experiments
