// What is made of a model or a scene before one is looked for in the other.
#pragma once

#include <memory>
#include <mutex>
#include <opencv2/core/affine.hpp>
#include <string>
#include <utility>
#include <vector>

#include "estancia/recognition/dense_search.hpp"
#include "estancia/recognition/descriptors.hpp"
#include "estancia/recognition/range_image.hpp"
#include "estancia/recognition/recognition_options.hpp"
#include "estancia/recognition/refine.hpp"
#include "estancia/recognition/scales.hpp"
#include "estancia/recognition/stage_report.hpp"

namespace estancia {

/// A cloud as it is described for some lengths.
struct DescribedSurface {
  std::unique_ptr<const Surface> surface;
  SurfaceFeatures features;
  std::vector<StageReport> stages;
};

/// Whether normals look to the origin, where the cloud was seen from, or away from the middle of the cloud.
struct Orientation {
  bool outwards = false;
  cv::Point3d middle;
};

class PreparedModel {
 public:
  /// As it is described for the lengths of a scene, and the points that poses are tried with.
  struct Described : DescribedSurface {
    DenseModel tried;
  };

  PreparedModel(std::string name, PointCloud raw, PointCloud filtered, RecognitionOptions options,
                std::vector<StageReport> stages);

  const std::string& name() const { return name_; }
  double extent() const { return extent_; }              ///< diagonal of the box around it [m]
  const cv::Point3d& center() const { return center_; }  ///< mean of its points
  const std::vector<StageReport>& stages() const { return stages_; }

  /// Made when first asked for, and kept.
  std::shared_ptr<const Described> describedFor(const RecognitionScales& scales) const;

 private:
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

class PreparedScene {
 public:
  /// As it is described for some lengths, and what poses are tried with.
  struct Described : DescribedSurface {
    RecognitionScales scales;
    std::unique_ptr<const Surface> coarse;  ///< points of surface about a tolerance apart
    std::vector<int> parts;                 ///< smoothPartsOf(coarse), for global verification
    NearestField field;                     ///< of surface, for local frames and evidence
    RangeImage view{{}, 0};
    DenseScene dense() const { return {*surface, field, view}; }
  };

  PreparedScene(std::string name, PointCloud raw, PointCloud filtered, RecognitionOptions options,
                std::vector<StageReport> stages);

  const std::string& name() const { return name_; }
  /// T_scene_view, of the frame in which all that is made of it is.
  const cv::Affine3d& fromView() const { return fromView_; }
  /// Whether it looks like what a sensor at the viewpoint saw, so that hiding and seeing through count.
  bool hasView() const { return described_->view.known(); }
  double resolution() const { return resolution_; }  ///< of the raw cloud: resolutionOf() [m]
  double noise() const { return noise_; }            ///< standard deviation across the surface, estimated [m]
  const RecognitionScales& scales() const { return scales_; }      ///< where no model asks for others
  const Surface& surface() const { return *described_->surface; }  ///< for lengths()
  const std::vector<StageReport>& stages() const { return stages_; }

  /// lengths(), unless these do not suit the size of a model.
  RecognitionScales scalesFor(const PreparedModel& model) const;

  /// Made when first asked for, and kept.
  std::shared_ptr<const Described> describedFor(const RecognitionScales& scales) const;

 private:
  std::shared_ptr<const Described> describe(const RecognitionScales& scales) const;

  std::string name_;
  cv::Affine3d fromView_ = cv::Affine3d::Identity();
  PointCloud raw_, filtered_;  ///< finite points only; filtered_ is empty when no filter changed anything
  RecognitionOptions options_;
  double resolution_ = 0, spacing_ = 0, noise_ = 0;
  RecognitionScales scales_;
  std::shared_ptr<const Described> described_;
  std::vector<StageReport> stages_;
  mutable std::mutex mutex_;
  mutable std::vector<std::shared_ptr<const Described>> others_;
};

}  // namespace estancia
