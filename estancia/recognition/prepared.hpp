// What is made of a model or a scene before one is looked for in the other.
#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "estancia/recognition/descriptors.hpp"
#include "estancia/recognition/range_picture.hpp"
#include "estancia/recognition/recognizer.hpp"
#include "estancia/recognition/refine.hpp"

namespace estancia {

/// A cloud as it is described for some lengths.
struct DescribedSurface {
  std::unique_ptr<const Surface> surface;
  Features features;
  std::vector<StageReport> stages;

  /// Normals, keypoints and descriptors of a cloud without noise or with it.
  static DescribedSurface of(const std::string& name, const PointCloud& cloud,
                             const RecognitionOptions& options, const RecognitionLengths& lengths);
};

class PreparedModel {
 public:
  /// As it is described for the lengths of a scene, and the points that poses are tried with.
  struct Described : DescribedSurface {
    OrientedPoints few, many;
  };

  PreparedModel(std::string name, PointCloud filtered, RecognitionOptions options,
                std::vector<StageReport> stages);

  const std::string& name() const { return name_; }
  const PointCloud& cloud() const { return cloud_; }  ///< filtered; finite points only
  double extent() const { return extent_; }           ///< diagonal of the box around it [m]
  const std::vector<StageReport>& stages() const { return stages_; }

  /// Made when first asked for, and kept.
  std::shared_ptr<const Described> describedFor(const RecognitionLengths& lengths) const;

 private:
  std::string name_;
  PointCloud cloud_;
  RecognitionOptions options_;
  double extent_ = 0;
  std::vector<StageReport> stages_;
  mutable std::mutex mutex_;
  mutable std::vector<std::pair<RecognitionLengths, std::shared_ptr<const Described>>> described_;
};

class PreparedScene {
 public:
  PreparedScene(std::string name, PointCloud raw, PointCloud filtered, const RecognitionOptions& options,
                std::vector<StageReport> stages);

  const std::string& name() const { return name_; }
  const PointCloud& raw() const { return raw_; }  ///< finite points only
  double resolution() const {
    return resolution_;
  }                                        ///< of the raw cloud: from a point to the nearest other [m]
  double noise() const { return noise_; }  ///< standard deviation across the surface, estimated [m]
  const RecognitionLengths& lengths() const { return lengths_; }
  const Surface& surface() const { return *described_.surface; }  ///< filtered, with normals
  const Features& features() const { return described_.features; }
  const Surface& coarse() const { return *coarse_; }  ///< points of surface() about a tolerance apart
  const std::vector<int>& parts() const {
    return parts_;
  }  ///< smoothPartsOf(coarse()), for global verification
  const RangePicture& view() const { return view_; }
  const std::vector<StageReport>& stages() const { return stages_; }

 private:
  std::string name_;
  PointCloud raw_;
  double resolution_ = 0, noise_ = 0;
  RecognitionLengths lengths_;
  DescribedSurface described_;
  std::unique_ptr<const Surface> coarse_;
  std::vector<int> parts_;
  RangePicture view_;
  std::vector<StageReport> stages_;
};

}  // namespace estancia
