// Lists of objects in scenes: which model of which object lies where.
#pragma once

#include <cstddef>
#include <filesystem>
#include <opencv2/core/affine.hpp>
#include <string>
#include <vector>

namespace estancia::experiments {

/// Names are unique among scenes, and among models.
struct ModelPairs {
  struct Scene {
    std::string name;
    std::filesystem::path file;  ///< a cloud
  };
  struct Model {
    std::string name, object;  ///< several models may show one object
    std::filesystem::path file;
  };
  struct Pair {
    std::size_t scene, model;
    std::vector<cv::Affine3d> poses;  ///< T_scene_model, at least one
  };
  std::vector<Scene> scenes;
  std::vector<Model> models;  ///< those of left out pairs, too: they may be looked for where they are not
  std::vector<Pair> pairs;    ///< none of the same scene and model
  std::size_t leftOut = 0;    ///< rows whose scene is said not to be there

  /// Whether one of the object's models is in the scene.
  bool holds(std::size_t scene, const std::string& object) const;
};

struct ModelPairsOptions {
  std::string modelColumn = "model", poseColumn = "pose";
  std::string sceneFiles = "{}";  ///< a scene's file, where {} is what the list calls the scene
};

/// Reads a CSV with a header, a row a pair: `scene`, `object`, and the columns of a model's file and of a
/// pose's: a text of 16 numbers, row-major. Files are relative to the list. Further columns are passed over,
/// but for `scene_present`, where 0 leaves the row out.
/// Throws Error `file:line: …` on missing columns, cells and files, on a model of two objects, and on a pose
/// that is not rigid.
ModelPairs readModelPairs(const std::filesystem::path& list, const ModelPairsOptions& options = {});

/// Those in the scenes of these names; all models stay. Throws Error on a name that no scene has.
ModelPairs onlyScenes(const ModelPairs& pairs, const std::vector<std::string>& names);

}  // namespace estancia::experiments
