// Late fusion: combines the answers of the image classifier and the shape classifier for one object.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estancia/core/descriptor.hpp"
#include "estancia/objects/object_model.hpp"
#include "estancia/objects/predict.hpp"

namespace estancia {

/// The evidence for one object.
struct ObjectEvidence {
  /// Class probabilities by the labeler; empty: not asked.
  DescriptorView image = {};
  /// Share of the target classes in the labeler's whole answer.
  float coverage = 0;
  /// Mean gray of the image, 0 … 1; 0 without one.
  double brightness = 1;
  /// Class probabilities by the model; empty: the shape could not be described.
  DescriptorView shape = {};
  bool flat = false;
};

/// The first rule that applies: a flat object is none of the classes (an image of something); in the dark, or
/// with too little coverage, the shape decides; without a shape, the image; if both agree, both; else the
/// answer with the larger log-odds, where the shape's are those of its probability plus those of the class's
/// held-out accuracy. Throws Error as requireProbabilities() on probabilities of other classes.
FusedAnswer fuseAnswers(const ObjectModel& model, const ObjectEvidence& evidence);

}  // namespace estancia
