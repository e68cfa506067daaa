// Known objects in a cloud, and their poses: thesis chapter 2, stage by stage.
#pragma once

#include <cstddef>
#include <memory>
#include <opencv2/core/affine.hpp>
#include <string>
#include <vector>

#include "estancia/cloud/filter.hpp"
#include "estancia/core/point_cloud.hpp"
#include "estancia/core/progress.hpp"

namespace estancia {

/// Which stages, and their lengths. A length of 0 follows the clouds: their resolution, and the noise that is
/// estimated from the scene, so that clouds in other units give the same.
struct RecognitionOptions {
  FilterOptions modelFilter, sceneFilter;
  std::string keypoints = "uniform";               ///< uniform, harris3d, iss
  std::string descriptor = "shot";                 ///< shot, fpfh, spin-image
  std::string grouping = "geometric-consistency";  ///< geometric-consistency, hough
  std::string verification = "global";             ///< global, inliers
  double normalRadius = 0;                         ///< [m] of the points that a normal is fitted to
  double keypointSpacing = 0;                      ///< [m] between keypoints (uniform), or their support
  double descriptorRadius = 0;                     ///< [m] of what a descriptor sees
  std::size_t neighbours = 1;                      ///< nearest descriptors that become matches
  int threads = 0;                                 ///< 0: one a free core

  /// Known sets: "default", "thesis", "tight", "wide". Throws Error on others, naming the known ones.
  static RecognitionOptions preset(const std::string& name);
};

/// An object that was found.
struct Instance {
  std::string model;
  cv::Affine3d pose;        ///< T_scene_model
  std::size_t inliers = 0;  ///< model points that the scene confirms
  double confidence = 0;    ///< [0, 1]
};

/// What a stage took and left, for people.
struct StageReport {
  std::string stage;   ///< "keypoints"
  std::string detail;  ///< "uniform, 10 mm: 1,203 of 277,103 points"
  double seconds = 0;
};

class PreparedModel;  ///< filtered cloud, normals, keypoints, descriptors of a model
class PreparedScene;  ///< the same of a scene, and its noise and resolution

/// Looks for models in scenes. What a model or a scene needs is prepared once and shared; immutable and safe
/// to use from several threads.
class Recognizer {
 public:
  explicit Recognizer(RecognitionOptions options);

  /// Throws Error, naming the cloud, on one that is empty or too small to be described.
  std::shared_ptr<const PreparedModel> prepareModel(const std::string& name, const PointCloud& cloud) const;
  std::shared_ptr<const PreparedScene> prepareScene(const std::string& name, const PointCloud& cloud,
                                                    Progress& progress) const;

  /// The instances of a model, best first; `stages`, when given, is told what each stage kept.
  std::vector<Instance> find(const PreparedModel& model, const PreparedScene& scene,
                             std::vector<StageReport>* stages = nullptr) const;

  const RecognitionOptions& options() const { return options_; }

 private:
  RecognitionOptions options_;
};

}  // namespace estancia
