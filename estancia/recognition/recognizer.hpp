// Object recognition: finds known objects and their 6-DoF poses in a point cloud.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <limits>
#include <memory>
#include <opencv2/core/affine.hpp>
#include <string>
#include <vector>

#include "estancia/core/point_cloud.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/recognition/recognition_options.hpp"

namespace estancia {

/// A model in a pose.
struct Detection {
  std::string model;
  /// T_scene_model.
  cv::Affine3d pose;
  /// Model points that the scene supports, of those that were tried.
  std::size_t inliers = 0;
  /// In [0, 1]. With verification by evidence 1 − falseAlarmRate; else the supported share of what should be
  /// visible of the model (InlierCounts in verify.hpp).
  double confidence = 0;
  /// With verification by evidence: the probability that a model that is not in this scene has as much
  /// evidence (FalseAlarmModel in pose_candidates.hpp). Else NaN: unknown.
  double falseAlarmRate = std::numeric_limits<double>::quiet_NaN();
  /// Mean of the model's points, in the model's frame [m].
  cv::Point3d center;
};

/// Input and output counts of a stage, in words.
struct StageReport {
  /// "keypoints".
  std::string stage;
  /// "uniform, 0.01 m: 1203 of 277103 points".
  std::string detail;
  double seconds = 0;
};

/// A filtered model with normals, keypoints and descriptors at the scales of the scenes (prepared.hpp).
class PreparedModel;
/// A scene prepared for recognition, with its noise and resolution (prepared.hpp).
class PreparedScene;
/// The poses of one model in one scene that are worth verifying (pose_candidates.hpp).
struct PoseCandidates;

/// Looks for models in scenes (thesis chapter 2): addModel() once for each object, detect() for each scene.
/// The const functions may be called from several threads; results do not depend on the number of threads.
class Recognizer {
 public:
  /// Throws Error as validate(RecognitionOptions) does.
  explicit Recognizer(RecognitionOptions options = {});

  /// Prepares and keeps a model. Throws Error (invalidInput, insufficientData), naming the model, on a cloud
  /// that is empty, or too small to be described.
  void addModel(const std::string& name, const PointCloud& cloud);
  /// The detections of all models in a scene, most confident first. Throws Error as prepareScene() and find()
  /// do; Interrupted. `maybe`: as of verify().
  std::vector<Detection> detect(const PointCloud& scene, Progress& progress = Progress::none(),
                                std::vector<Detection>* maybe = nullptr) const;

  // ---- the same in steps, for models and scenes that are used several times

  std::shared_ptr<const PreparedModel> prepareModel(const std::string& name, const PointCloud& cloud,
                                                    Progress& progress = Progress::none()) const;
  /// Throws Error (invalidInput, insufficientData), naming the scene, on a cloud that is empty, too small to
  /// be described, or without extent.
  std::shared_ptr<const PreparedScene> prepareScene(const std::string& name, const PointCloud& cloud,
                                                    Progress& progress = Progress::none()) const;
  /// Prepares a cloud that was filtered before: `filtered` is described, `cloud` gives noise and view.
  std::shared_ptr<const PreparedScene> prepareScene(const std::string& name, const PointCloud& cloud,
                                                    const PointCloud& filtered) const;

  /// The candidate poses of one model; `stages`, when given, gets a report of each stage. The model is
  /// described at the scene's scales when they are first needed, and kept so; model and scene must outlive
  /// the candidates. Throws Error (mismatch, invalidInput) on a model and a scene in different units, and on
  /// a planar model.
  PoseCandidates search(const PreparedModel& model, const PreparedScene& scene,
                        std::vector<StageReport>* stages = nullptr) const;
  /// The detections of all models that were searched in a scene, most confident first. By evidence they are
  /// verified together: a point of the scene supports one instance of one model only.
  /// What has up to ten times the rate of false alarms that is allowed is `maybe` there.
  std::vector<Detection> verify(const std::vector<PoseCandidates>& candidates,
                                std::vector<Detection>* maybe = nullptr) const;
  /// search() and verify() of one model.
  std::vector<Detection> find(const PreparedModel& model, const PreparedScene& scene,
                              std::vector<StageReport>* stages = nullptr) const;

  const RecognitionOptions& options() const { return options_; }

 private:
  RecognitionOptions options_;
  std::vector<std::shared_ptr<const PreparedModel>> models_;
};

}  // namespace estancia
