// Known objects in a cloud, and their poses: thesis chapter 2, stage by stage.
#pragma once

#include <cstddef>
#include <memory>
#include <opencv2/core/affine.hpp>
#include <string>
#include <vector>

#include "estancia/core/point_cloud.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/recognition/recognition_options.hpp"
#include "estancia/recognition/stage_report.hpp"

namespace estancia {

/// An object that was found.
struct Detection {
  std::string model;
  cv::Affine3d pose;        ///< T_scene_model
  std::size_t inliers = 0;  ///< model points that the scene confirms, of those that are tried
  /// [0, 1]. How much of what should be seen of the model is: Evidence in verify.hpp; where evidence
  /// verifies: e² / (e² + accept²), 0.5 for what is just accepted.
  double confidence = 0;
  cv::Point3d center;  ///< of the model's points, in the model's frame [m]
};

/// Prepared.hpp: filtered cloud; normals, keypoints, descriptors for the lengths of a scene.
class PreparedModel;
class PreparedScene;  ///< prepared.hpp: the same of a scene, and its noise and resolution

/// Looks for models in scenes. What a model or a scene needs is prepared once and shared; safe to use from
/// several threads, and the same for any number of them.
class Recognizer {
 public:
  /// Throws Error as RecognitionOptions::check() does.
  explicit Recognizer(RecognitionOptions options);

  /// Throws Error, naming the cloud, on one that is empty or too small to be described.
  std::shared_ptr<const PreparedModel> prepareModel(const std::string& name, const PointCloud& cloud) const;
  std::shared_ptr<const PreparedScene> prepareScene(const std::string& name, const PointCloud& cloud,
                                                    Progress& progress) const;
  /// The same of a cloud that was filtered before: `filtered` is described, `cloud` tells noise and view.
  std::shared_ptr<const PreparedScene> prepareScene(const std::string& name, const PointCloud& cloud,
                                                    const PointCloud& filtered) const;

  /// The instances of a model, best first; `stages`, when given, is told what each stage kept. What a model
  /// needs for the scene's lengths is made when it is first needed, and kept. Throws Error on a model and a
  /// scene in different units, and on a model that is but a plane.
  std::vector<Detection> find(const PreparedModel& model, const PreparedScene& scene,
                              std::vector<StageReport>* stages = nullptr) const;

  const RecognitionOptions& options() const { return options_; }

 private:
  RecognitionOptions options_;
};

}  // namespace estancia
