// Object prediction of a sequence: reads, segments and classifies its frames one after another.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "estancia/core/options.hpp"
#include "estancia/objects/clustered_frame.hpp"
#include "estancia/objects/predict.hpp"
#include "estancia/sequences/sequence.hpp"

namespace estancia {

struct PredictSequenceOptions {
  PredictOptions objects = {};
  std::size_t first = 0;
  std::size_t every = 1;
  std::size_t maxFrames = 0;
  bool strict = false;
};
/// Without the groups "clusters" and "crop" of `objects`, which have their own.
OptionGroup declare(PredictSequenceOptions& options);

struct PredictedFrame {
  std::string name;
  ClusteredFrame frame;
  /// One a cluster, in their order.
  std::vector<PredictedObject> objects;
  /// Time of the segmentation [s].
  double clusterSeconds = 0;
  PredictSeconds seconds;
};

/// Gives each frame to `use`, in order; the reasons for skipped frames go to `skipped`. Returns the number of
/// frames; on interruption it returns early. Throws Error (invalidOption) when the first frame is beyond the
/// last, (invalidInput) without depth or camera, (fileUnreadable) when no frame can be read.
std::size_t predictSequence(const Sequence& sequence, ObjectPredictor& predictor,
                            const PredictSequenceOptions& options,
                            const std::function<void(const PredictedFrame&)>& use,
                            const std::function<void(const std::string&)>& skipped = {});

/// {"frame", "objects": [{"object", "views", "box", "center", "flat", "at_border", "image", "coverage",
/// "shape", "answer": {"class", "probability", "source", "why"}, "problem"}], "seconds"}; `image` and `shape`
/// are {"class", "probability", "classes": {NAME: p}}, or null without an answer.
nlohmann::ordered_json toJson(const PredictedFrame& frame, const std::vector<std::string>& classes);

}  // namespace estancia
