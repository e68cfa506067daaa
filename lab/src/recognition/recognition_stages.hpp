// Recognition stages: the recognizer at work in the recognition experiment.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <opencv2/core/affine.hpp>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

#include "estancia/core/point_cloud.hpp"
#include "recognition/filtered_clouds.hpp"
#include "recognition/recognition.hpp"

namespace estancia::experiments {

/// Keeps the models and, in FOLDER/filtered, filtered clouds. Several threads may recognize at once.
class RecognitionStages final : public RecognitionWork {
 public:
  /// Reads the models. Throws Error on those that cannot be read, and on symmetries of unknown models.
  RecognitionStages(const RecognitionExperimentOptions& options, const ModelPairs& pairs,
                    const std::filesystem::path& folder);
  ~RecognitionStages() override;

  std::string inputs(const RecognitionUnit& unit) const override;

  /// On one thread. What cannot be described is not found. Throws Error when the scene cannot be read.
  RecognitionFound recognize(const RecognitionTask& task) override;

 private:
  struct Model {
    PointCloud cloud;
    std::string digest;
    cv::Point3d center;
    std::vector<cv::Affine3d> symmetries;
  };
  /// A model as a recognizer describes it.
  struct Entry;
  /// A recognizer, and the models as it describes them.
  struct Recipe;
  std::shared_ptr<Recipe> recipeOf(const RecognitionUnit& unit);
  void look(const RecognitionTask& task, RecognitionFound& found);
  const Entry& modelOf(Recipe& recipe, const RecognitionSearch& search);
  PointCloud withNoise(PointCloud cloud, const RecognitionUnit& unit) const;
  /// T_searched_scene.
  cv::Affine3d frameOf(const RecognitionUnit& unit) const;
  /// True poses of the model in the task's scene.
  std::size_t posesOf(const RecognitionTask& task, std::size_t model) const;
  bool isCorrect(const RecognitionTask& task, std::size_t model, const cv::Affine3d& pose) const;

  const RecognitionExperimentOptions& options_;
  const ModelPairs& pairs_;
  FilteredClouds clouds_;
  std::vector<Model> models_;
  std::vector<std::string> sceneDigests_;
  std::mutex mutex_;
  std::map<std::string, std::weak_ptr<Recipe>> recipes_;
  std::shared_ptr<Recipe> latest_;
};

}  // namespace estancia::experiments
