// Known objects in a cloud, and their poses: thesis chapter 2, stage by stage.
#pragma once

#include <cstddef>
#include <memory>
#include <opencv2/core/affine.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "estancia/cloud/filter.hpp"
#include "estancia/core/point_cloud.hpp"
#include "estancia/core/progress.hpp"

namespace estancia {

/// Which stages, and their lengths. A length of 0 follows the scene, its resolution and its noise, so that
/// clouds in other units give the same.
struct RecognitionOptions {
  FilterOptions modelFilter, sceneFilter;
  std::string surface = "filtered";   ///< filtered: the filter's points as they are, plane normals;
                                      ///< mean: averaged over the raw points around them, as noise
                                      ///< asks for, and models are given the scene's noise
  std::string keypoints = "uniform";  ///< uniform, harris3d, iss
  std::string descriptor = "shot";    ///< shot, fpfh, spin-image
  std::string grouping = "geometric-consistency";  ///< geometric-consistency, hough, local-frames
  std::string verification = "global";             ///< global, inliers, evidence
  double normalRadius = 0;                         ///< [m] of the points that a normal is fitted to
  std::size_t normalNeighbours = 0;                ///< of filtered surfaces: nearest points that a normal is
                                                   ///< fitted to, whatever their distance; 0: the radius says
  double keypointSpacing = 0;                      ///< [m] between keypoints (uniform), or their support
  double descriptorRadius = 0;                     ///< [m] of what a descriptor sees
  double consistency = 0;           ///< [m] up to which matches agree: the bin of Hough voting, too
  double tolerance = 0;             ///< [m] between a model point and the scene point that confirms it
  double sceneKeypointSpacing = 0;  ///< [m] between uniform keypoints of a scene; 0: as in models
  std::string matchEach = "scene";  ///< scene, model: whose keypoints each get their nearest
  std::size_t neighbours = 1;       ///< nearest descriptors that become matches
  double matchDistance = 0;         ///< the largest between them, in lengths of the scene's; 0: any
  std::size_t minimalMatches = 3;   ///< that must agree
  std::size_t hypotheses = 100;     ///< with most matches that are refined and verified
  double accept = 0.6;  ///< share of what should be seen of a model that must be; or the least evidence
  std::optional<cv::Point3d> viewpoint;  ///< where the scene's sensor stood [m], in the scene's frame; none:
                                         ///< where the cloud says; else at its origin, looking along z
  int threads = 0;                       ///< 0: one a usable core

  /// The known sets, each with one line of explanation: default, classical, thesis, tight, wide.
  static std::vector<std::pair<std::string, std::string>> presets();
  /// One of them. Throws Error on others, naming the known ones.
  static RecognitionOptions preset(const std::string& name);
};

/// The lengths [m] that a scene is looked at with: those of the options, else what fits the scene.
struct RecognitionLengths {
  double normalRadius = 0, keypointSpacing = 0, descriptorRadius = 0, consistency = 0, tolerance = 0;
  // Of mean surfaces, for which they are rounded, so that scenes alike share what models are prepared for:
  double unit = 0;     ///< spacing of the scene's points, within what suits the model's size
  double noise = 0;    ///< standard deviation
  double spacing = 0;  ///< of the scene's points

  bool operator==(const RecognitionLengths&) const = default;
};

/// An object that was found.
struct Instance {
  std::string model;
  cv::Affine3d pose;        ///< T_scene_model
  std::size_t inliers = 0;  ///< model points that the scene confirms, of those that are tried
  double confidence =
      0;  ///< [0, 1]. How much of what should be seen of the model is: Evidence in verify.hpp; where evidence
          ///< verifies: e² / (e² + accept²), 0.5 for what is just accepted
  cv::Point3d centre;  ///< of the model's points, in the model's frame [m]
};

/// What a stage took and left, for people.
struct StageReport {
  std::string stage;   ///< "keypoints"
  std::string detail;  ///< "uniform, 10 mm: 1,203 of 277,103 points"
  double seconds = 0;
};

class PreparedModel;  ///< prepared.hpp: filtered cloud; normals, keypoints, descriptors for the lengths of a
                      ///< scene
class PreparedScene;  ///< prepared.hpp: the same of a scene, and its noise and resolution

/// Looks for models in scenes. What a model or a scene needs is prepared once and shared; safe to use from
/// several threads, and the same for any number of them.
class Recognizer {
 public:
  /// Throws Error on unknown stages, naming the known ones, and on lengths and numbers that make no sense.
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
  std::vector<Instance> find(const PreparedModel& model, const PreparedScene& scene,
                             std::vector<StageReport>* stages = nullptr) const;

  const RecognitionOptions& options() const { return options_; }

 private:
  RecognitionOptions options_;
};

}  // namespace estancia
