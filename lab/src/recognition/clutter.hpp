// Clutter: seeded scenes of known models that touch each other, one view, no table, with their true poses.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <opencv2/core/affine.hpp>
#include <string>
#include <vector>

#include "estancia/core/options.hpp"
#include "estancia/core/point_cloud.hpp"
#include "recognition/model_pairs.hpp"

namespace estancia::experiments {

struct ClutterOptions {
  /// 0: none.
  std::size_t scenes = 0;
  /// Objects of a scene; at most as many as there are different ones.
  std::size_t fewest = 3, most = 5;
  /// Distance of an object's center [m].
  double nearest = 0.8, farthest = 1.1;
  /// Largest angle between the views of the model and of the scene [degrees]: models show one side.
  double tilt = 25;
  /// Largest share of an object's silhouette that is in front of or behind others when it is put there.
  double overlap = 0.15;
  std::uint64_t seed = 1;
};
OptionGroup declare(ClutterOptions& options);

/// A model as its sensor at the origin saw it.
struct ClutterModel {
  /// At most one model of an object is in a scene.
  std::string object;
  PointCloud cloud;
};

struct ClutterScene {
  struct Instance {
    std::size_t model;
    /// T_scene_model.
    cv::Affine3d pose;
  };
  /// What a Kinect at the origin sees: 640 × 480 pixels at a focal length of 525, without noise.
  PointCloud cloud;
  std::vector<Instance> instances;
};

/// The scene with that number. Depends on the seed and the number alone. Throws Error (invalidInput) on
/// models without points.
ClutterScene makeClutter(const std::vector<ClutterModel>& models, const ClutterOptions& options,
                         std::size_t number);

/// The models of `pairs` in scenes that are made of them, and written into `folder`. Throws Error when a
/// model cannot be read or a scene not be written.
ModelPairs withClutter(const ModelPairs& pairs, const ClutterOptions& options,
                       const std::filesystem::path& folder);

/// A rotation and a shift of some meters, as between a sensor and a robot's map; seeded.
cv::Affine3d randomFrame(std::uint64_t seed);

}  // namespace estancia::experiments
