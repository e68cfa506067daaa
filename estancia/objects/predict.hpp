// What the things in the frames of a sequence are, frame by frame: what their images say, what their shapes
// say, and which to believe.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "estancia/cloud/crop_object.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/label/labeler.hpp"
#include "estancia/objects/clustered_frame.hpp"
#include "estancia/objects/late_fusion.hpp"
#include "estancia/objects/object_model.hpp"
#include "estancia/objects/tracks.hpp"

namespace estancia {

struct PredictOptions {
  TrackOptions tracks = {};
  CropOptions patches = {};
  int threads = 0;  ///< 0: one a usable core; the answers do not depend on it
};

/// One thing in one frame. The words are those of the model's study.
struct PredictedObject {
  std::size_t thing = 0;           ///< its number in the sequence
  std::size_t views = 0;           ///< of it so far, with this one
  cv::Rect box;                    ///< in the image
  std::vector<float> seen, shape;  ///< what this view's image and shape say; empty where they say nothing
  float mass = 0;                  ///< of the words in the labeler's whole answer
  std::string problem;  ///< why the image or the shape of this view says nothing; "" when all is well
  FusedAnswer belief;   ///< of all views so far, by LogOpinionPool
};

/// Where the time of a frame went [s].
struct PredictSeconds {
  double patches = 0, labeler = 0, shapes = 0, classifier = 0;
};

class ObjectPredictor {
 public:
  /// `labeler` may be missing: then the shapes alone are asked. Both must outlive the predictor. Its answers
  /// are corrected by the model's prior when it is the labeler that the model was learned from. Throws Error
  /// when the labeler knows a word of the study by no label, or discovers its words on the way.
  ObjectPredictor(const ObjectModel& model, Labeler* labeler, const PredictOptions& options = {});
  ~ObjectPredictor();

  /// The things of the next frame, one a cluster, in their order. Throws Interrupted when the user asks to
  /// stop.
  std::vector<PredictedObject> predict(const ClusteredFrame& frame, const std::optional<Pose>& pose,
                                       PredictSeconds* seconds = nullptr);

  /// Whether the labeler's answers are corrected.
  bool corrects() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace estancia
