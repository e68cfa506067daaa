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

  struct Found {
    /// T_camera_model.
    cv::Affine3d pose;
    /// segmentFit() there.
    double fit = 0;
  };
  /// The poses of a model that explain most of a segment, best first; none of one with too few points.
  /// `depth`: CV_32F [m] of `camera`; `segment`: CV_8U, not 0 on it. Throws Error (Interrupted).
  std::vector<Found> find(const Model& model, const cv::Mat& depth, const cv::Mat& segment,
                          const CameraIntrinsics& camera) const;

 private:
  Recognizer recognizer_;
  std::vector<Model> models_;
};

/// How well a model in a pose explains a segment: the pixels of the segment where the model has the measured
/// depth (a pixel counts 1, less where it deviates), of all its pixels and those where the model would stand
/// before what was measured. In [0, 1]. What is behind something counts neither way. `seen`: when given, the
/// model's points that are where the segment is become 1.
double segmentFit(const KnownObjects::Model& model, const cv::Affine3d& pose, const cv::Mat& depth,
                  const cv::Mat& segment, const CameraIntrinsics& camera,
                  std::vector<std::uint8_t>* seen = nullptr);

}  // namespace estancia
