// Object search: several models from files in one scene; a model that cannot be used costs only itself.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "estancia/core/point_cloud.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/recognition/recognizer.hpp"

namespace estancia {

struct ModelFile {
  std::string name;
  std::filesystem::path cloud;
  /// One of lengthUnits(), of its coordinates.
  std::string unit = "m";
};

/// Parses FILE or NAME=FILE; the name of a plain FILE is its stem. Throws Error (invalidOption) when two
/// models have one name.
std::vector<ModelFile> modelFilesOf(const std::vector<std::string>& words, const std::string& unit = "m");

struct SearchedModel {
  std::string name;
  PointCloud cloud;
  std::vector<StageReport> stages;
};

struct SearchResult {
  /// Most confident first.
  std::vector<Detection> detections;
  /// What may be there: Recognizer::verify().
  std::vector<Detection> maybe;
  std::shared_ptr<const PreparedScene> scene;
  /// In the order of the files.
  std::vector<SearchedModel> models;
  /// Name and reason of each model that could not be used.
  std::vector<std::pair<std::string, std::string>> failed;

  /// Throws Error (unknownName).
  const SearchedModel& model(const std::string& name) const;
};

/// Looks for all models in one scene. Throws Error as prepareScene() does, and when no model can be used: the
/// failure of the only one, else invalidInput; Interrupted.
SearchResult searchScene(const Recognizer& recognizer, const std::string& name, const PointCloud& scene,
                         const std::vector<ModelFile>& models, Progress& progress = Progress::none());

/// {"instances": [{"model", "pose" (T_scene_model, row by row), "inliers", "confidence", "false_alarm_rate"
/// (where poses are verified by evidence)}], "maybe": the same, of what is not sure, "failed":
/// [{"model", "reason"}]}, the latter two if there are any.
nlohmann::ordered_json toJson(const SearchResult& result);
/// {"scene": [{"stage", "detail", "seconds"}], "models": {NAME: the same}}.
nlohmann::ordered_json stagesJson(const SearchResult& result);

}  // namespace estancia
