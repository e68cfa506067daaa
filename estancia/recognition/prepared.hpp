// Prepared models and scenes: surfaces, keypoints and descriptors at the scales of a scene.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <memory>
#include <mutex>
#include <opencv2/core/affine.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "estancia/recognition/descriptors.hpp"
#include "estancia/recognition/pose_score.hpp"
#include "estancia/recognition/range_image.hpp"
#include "estancia/recognition/recognition_options.hpp"
#include "estancia/recognition/recognizer.hpp"
#include "estancia/recognition/scales.hpp"

namespace estancia {

/// Writes the reports of consecutive stages into `stages`, if given: each took the time since the one before.
class StageLog {
 public:
  explicit StageLog(std::vector<StageReport>* stages) : stages_(stages) {}
  void add(const std::string& stage, std::string detail);
  /// Stages that were run before, with this before their names.
  void append(const std::vector<StageReport>& stages, const std::string& prefix = "");

 private:
  std::vector<StageReport>* stages_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/// A cloud described at some scales.
struct DescribedSurface {
  std::unique_ptr<const Surface> surface;
  SurfaceFeatures features;
  std::vector<StageReport> stages;
};

/// Direction of normals: towards the sensor, or away from the center of the cloud.
struct Orientation {
  bool outwards = false;
  cv::Point3d center;
  cv::Point3d sensor = {};
};

/// A model of the recognition, with everything that does not depend on a scene. Invariant: everything but
/// `described_` is constant; `mutex_` guards that cache, whose entries never change. Thread-safe.
class PreparedModel {
 public:
  /// Described at the scales of a scene, with the points that poses are tried with.
  struct Described : DescribedSurface {
    DenseModel dense;
    NearestField field;      ///< field of the surface, if the model is verified by evidence
    RangeImage view{{}, 0};  ///< what its sensor saw of a model of one side
  };

  PreparedModel(std::string name, PointCloud raw, PointCloud filtered, RecognitionOptions options,
                std::vector<StageReport> stages);

  const std::string& name() const { return name_; }
  double extent() const { return extent_; }              ///< diagonal of the bounding box [m]
  const cv::Point3d& center() const { return center_; }  ///< mean of its points
  const std::vector<StageReport>& stages() const { return stages_; }

  /// Computed on first use, and kept.
  std::shared_ptr<const Described> describedFor(const RecognitionScales& scales) const;

 private:
  std::shared_ptr<const Described> describe(const RecognitionScales& scales) const;
  void addExtent(Described& fresh, const RecognitionScales& scales) const;

  std::string name_;
  PointCloud raw_, cloud_;  ///< finite points only; cloud_ is filtered
  RecognitionOptions options_;
  double extent_ = 0, noise_ = 0;
  cv::Point3d center_;
  Orientation orientation_;
  std::vector<StageReport> stages_;
  mutable std::mutex mutex_;
  mutable std::vector<std::pair<RecognitionScales, std::shared_ptr<const Described>>> described_;
};

/// A scene of the recognition, in the frame of its sensor's view. Invariant: everything but `others_` is
/// constant; `mutex_` guards that cache of descriptions at other scales, whose entries never change.
/// Thread-safe.
class PreparedScene {
 public:
  /// Described at some scales, with what poses are verified by.
  struct Described : DescribedSurface {
    RecognitionScales scales;
    std::unique_ptr<const Surface> coarse;  ///< points of the surface about a tolerance apart
    std::vector<int> parts;                 ///< smoothPartsOf(coarse), for global verification
    NearestField field;                     ///< field of the surface, for local frames and evidence
    std::vector<cv::Matx33f> gradients;     ///< colorGradients(surface), if colors count
    RangeImage view{{}, 0};
    RangeImage measured{{}, 0};  ///< the raw points, if models are verified by evidence
    Outline outline;             ///< edges and planes, likewise
    DenseScene dense() const {
      return {*surface,
              field,
              view,
              &gradients,
              measured.known() ? &measured : nullptr,
              outline.empty() ? nullptr : &outline};
    }
  };

  /// `sensor`: its position, if the grid of the cloud determines it (viewpointOfGrid()).
  PreparedScene(std::string name, PointCloud raw, PointCloud filtered, RecognitionOptions options,
                std::vector<StageReport> stages, const std::optional<cv::Point3d>& sensor = {});

  const std::string& name() const { return name_; }
  /// T_scene_view: everything here is in the frame of the view.
  const cv::Affine3d& fromView() const { return fromView_; }
  /// Whether the cloud is consistent with a sensor at the viewpoint, so that occlusion and free space count.
  bool hasView() const { return described_->view.known(); }
  /// Whether it follows from the points where the sensor stood; assumed: at the origin, as they were thinned.
  enum class ViewKnown { no, assumed, yes };
  ViewKnown viewKnown() const { return viewKnown_; }
  /// Where the sensor stood in the scene's frame [m], if that was not the origin and follows from the points
  /// alone (viewpointOfGrid(), findViewpoints()).
  const std::optional<cv::Point3d>& estimatedViewpoint() const { return estimatedViewpoint_; }
  double resolution() const { return resolution_; }  ///< resolution of the raw cloud: resolutionOf() [m]
  double noise() const { return noise_; }            ///< standard deviation across the surface, estimated [m]
  const RecognitionScales& scales() const { return scales_; }      ///< unless a model needs others
  const Surface& surface() const { return *described_->surface; }  ///< at scales()
  const std::vector<StageReport>& stages() const { return stages_; }

  /// scales(), adapted to the size of a model.
  RecognitionScales scalesFor(const PreparedModel& model) const;

  /// Computed on first use, and kept.
  std::shared_ptr<const Described> describedFor(const RecognitionScales& scales) const;

 private:
  std::shared_ptr<const Described> describe(const RecognitionScales& scales) const;

  std::string name_;
  cv::Affine3d fromView_ = cv::Affine3d::Identity();
  std::optional<cv::Point3d> estimatedViewpoint_;
  ViewKnown viewKnown_ = ViewKnown::yes;
  PointCloud raw_, filtered_;  ///< finite points only; filtered_ is empty without a filter
  RecognitionOptions options_;
  double resolution_ = 0, spacing_ = 0, noise_ = 0;
  RecognitionScales scales_;
  std::shared_ptr<const Described> described_;
  std::vector<StageReport> stages_;
  mutable std::mutex mutex_;
  mutable std::vector<std::shared_ptr<const Described>> others_;
};

}  // namespace estancia
