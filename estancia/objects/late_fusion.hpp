// A thing's 2-D answer, its 3-D answer, and which one to believe.
#pragma once

#include <string>

#include "estancia/core/descriptor.hpp"
#include "estancia/objects/object_model.hpp"

namespace estancia {

/// What is known of one thing.
struct ObjectEvidence {
  DescriptorView seen;    ///< what the labeler says of its image, in the words of the study; empty: not asked
  float mass = 0;         ///< of that in the labeler's whole answer
  double brightness = 1;  ///< of its image: mean gray, 0 … 1; 0 where there is none
  DescriptorView shape;   ///< what the model says of its shape; empty: could not be described
  bool flat = false;
};

struct FusedAnswer {
  enum class Source { none, seen, shape, both };
  Source source = Source::none;
  int word = -1;  ///< of the study
  double probability = 0;
  std::string why;  ///< one sentence
};

/// First that applies: a flat thing is believed to be none (an image of something); in the dark, or where
/// the labeler knows nothing of the words, the shape is believed; where there is no shape, the image; where
/// both agree, both; else what is more likely right: by its own probability and, of the shape, by how often
/// that word was right of what was held out in training (the sum of the log-odds). Throws Error when an
/// answer is in the words of another study.
FusedAnswer fuseAnswers(const ObjectModel& model, const ObjectEvidence& evidence);

}  // namespace estancia
