// Object prediction: classifies the objects of each frame by image, by shape, and by their late fusion.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "estancia/cloud/crop_object.hpp"
#include "estancia/core/camera.hpp"
#include "estancia/core/options.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/labelers/labeler.hpp"
#include "estancia/objects/collect.hpp"
#include "estancia/objects/object_model.hpp"
#include "estancia/segmentation/clusters.hpp"

namespace estancia {

struct ClusteredFrame;

struct PredictOptions {
  ClusterOptions clusters = {};
  CropOptions crops = {};
  int threads = 0;
};
OptionGroup declare(PredictOptions& options);

/// The fused answer of image classifier and shape classifier.
struct FusedAnswer {
  enum class Source { none, image, shape, both };
  Source source = Source::none;
  /// Index of the target class; −1: none of them.
  int classIndex = -1;
  double probability = 0;
  /// The reason, as one sentence.
  std::string why = {};
};

/// One object in one frame. Probabilities are those of the model's target classes.
struct PredictedObject {
  /// Number of the tracked object in the sequence.
  std::size_t instance = 0;
  /// Views of it so far, with this one.
  std::size_t views = 0;
  /// In the image.
  cv::Rect box = {};
  /// Probabilities for this view by image and by shape; empty without an answer.
  std::vector<float> image = {}, shape = {};
  /// Share of the target classes in the labeler's whole answer.
  float coverage = 0;
  /// Why the image or the shape of this view has no answer; "" otherwise.
  std::string problem = {};
  /// Probabilities over all views so far, fused by LogOpinionPool.
  FusedAnswer answer = {};
};

/// Time of the stages of a frame [s].
struct PredictSeconds {
  double crops = 0, labeler = 0, shapes = 0, classifier = 0;
};

class ObjectPredictor {
 public:
  /// Without a `labeler`, only shapes are classified. It must outlive the predictor. Its answers are
  /// corrected by the model's prior if it labeled the training data. Throws Error (unknownName) when the
  /// labeler has no label for a target class, (invalidInput) when it discovers its labels, and on invalid
  /// options.
  ObjectPredictor(const ObjectModel& model, Labeler* labeler, const PredictOptions& options = {});
  ~ObjectPredictor();

  /// The objects of the next frame: `image` is BGR, `depth` CV_32F [m] of `camera`, both of the same view.
  /// Throws Error (invalidInput) on other images; Interrupted.
  std::vector<PredictedObject> predict(const cv::Mat& image, const cv::Mat& depth,
                                       const CameraIntrinsics& camera, const std::optional<Pose>& pose = {});

  /// Predicts a segmented frame (clustered_frame.hpp): one object a cluster, in their order.
  std::vector<PredictedObject> predict(const ClusteredFrame& frame, const std::optional<Pose>& pose = {},
                                       PredictSeconds* seconds = nullptr);

  /// Whether the labeler's answers are corrected.
  bool correctsPrior() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace estancia
