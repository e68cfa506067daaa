// Model pairs: ground truth of object recognition, the poses of object models in scenes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <opencv2/core/affine.hpp>
#include <string>
#include <vector>

#include "estancia/core/options.hpp"

namespace estancia::experiments {

/// Names are unique among scenes, and among models.
struct ModelPairs {
  struct Scene {
    std::string name;
    /// A point cloud.
    std::filesystem::path file;
  };
  struct Model {
    /// Several models may show one object.
    std::string name, object;
    std::filesystem::path file;
  };
  struct Pair {
    std::size_t scene, model;
    /// T_scene_model, at least one.
    std::vector<cv::Affine3d> poses;
  };
  std::vector<Scene> scenes;
  /// Also those of left-out pairs: they serve as negatives.
  std::vector<Model> models;
  /// At most one per scene and model.
  std::vector<Pair> pairs;
  /// Rows with `scene_present` 0.
  std::size_t leftOut = 0;

  /// Whether one of the object's models is in the scene.
  bool holds(std::size_t scene, const std::string& object) const;
};

struct ModelPairsOptions {
  /// Columns with the files of model and pose.
  std::string modelColumn = "model", poseColumn = "pose";
  /// File of a scene; {} is its name in the list.
  std::string sceneFiles = "{}";
};
OptionGroup declare(ModelPairsOptions& options);

/// Reads a CSV with a header and one row per pair: `scene`, `object`, and the files of the model and of the
/// pose (16 numbers, row-major), relative to the list. Other columns are ignored, except `scene_present`: 0
/// leaves the row out. Or a folder with the files Configscene*.ini of the published SHOT data set.
/// Throws Error `FILE:LINE: …` on missing columns, cells and files, on a model of two objects, and on a pose
/// that is not rigid.
ModelPairs readModelPairs(const std::filesystem::path& list, const ModelPairsOptions& options = {});

/// The pairs in the named scenes; all models stay. Throws Error on an unknown scene.
ModelPairs onlyScenes(const ModelPairs& pairs, const std::vector<std::string>& names);

}  // namespace estancia::experiments
