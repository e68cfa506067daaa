// Known objects: clouds of single things that are to be recognized in a map, each under its name.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core/affine.hpp>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "estancia/core/camera.hpp"
#include "estancia/recognition/object_search.hpp"
#include "estancia/recognition/recognizer.hpp"

namespace estancia {

/// Clouds of things from 2 cm to 10 m.
class KnownObjects {
 public:
  struct Model {
    std::string name;
    /// SHA-256 of its file, with its unit unless that is the meter: another one is another model.
    std::string digest;
    /// Diagonal of its bounding box [m].
    double extent = 0;
    /// Some of its points, about `spacing` [m] apart.
    std::vector<cv::Point3f> points = {};
    double spacing = 0;
    std::shared_ptr<const PreparedModel> prepared = {};
  };

  /// Reads and prepares them; looks for each in its own cloud, too, so that what can never be found is
  /// reported here. Throws Error, naming the file: as readCloud(); invalidInput on sizes that no thing has
  /// (other units) and on planes, insufficientData on few points, invalidOption on two equal names.
  explicit KnownObjects(const std::vector<ModelFile>& files);

  const std::vector<Model>& models() const { return models_; }

  /// Poses T_camera_model of a model in a segment, by how much of the segment they explain there (fit()),
  /// best first; none of one with too few points. A segment alone rarely proves a pose: several views do.
  /// `depth`: CV_32F [m] of `camera`; `segment`: CV_8U, not 0 on it. Throws Error (Interrupted).
  std::vector<cv::Affine3d> find(const Model& model, const cv::Mat& depth, const cv::Mat& segment,
                                 const CameraIntrinsics& camera) const;

 private:
  Recognizer recognizer_;
  std::vector<Model> models_;
};

/// Agreement of a model in a pose with a view: numbers of pixels. What is behind something counts neither
/// way.
struct ViewAgreement {
  double same = 0;     ///< where the model has the measured depth
  double before = 0;   ///< where it would stand before what was measured; edges are known within a pixel
  double inside = 0;   ///< `same` in the segment
  double segment = 0;  ///< all in the segment

  /// In [0, 1].
  double fit() const { return segment > 0 ? inside / (segment + before) : 0; }
};

/// `seen`: when given, the model's points that are where something was measured become 1.
ViewAgreement agreementIn(const KnownObjects::Model& model, const cv::Affine3d& pose, const cv::Mat& depth,
                          const cv::Mat& segment, const CameraIntrinsics& camera,
                          std::vector<std::uint8_t>* seen = nullptr);

}  // namespace estancia
