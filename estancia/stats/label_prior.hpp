// Label prior: statistics of networks' answers to images elsewhere, for runs that are too short for their
// own.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "estancia/core/vocabulary.hpp"

namespace estancia {

/// Statistics of the centered log-ratios of many places' images, and of these images' distances when each
/// label is standardized (the distance standardized-clr). Made by models/priors/make_prior.py.
struct LabelPrior {
  /// Mean and variance of each label's log-ratio; both empty where nothing is known of these labels.
  std::vector<float> center, variance;
  /// Quantiles 0, 1 … 100 % of the distances between images of different places.
  std::vector<double> distances;
  /// Participation ratio (Σ λ)²/Σ λ² of the images' unit vectors: how many directions they spread over.
  double dimensions = 0;

  /// The distance that is above this share of the pairs of different places; `share` in [0, 1].
  double distanceAt(double share) const;

  /// To go on with a map as it was begun.
  std::string toBytes() const;
  /// Throws Error (corruptFile) when they are damaged, or not of so many labels.
  static LabelPrior fromBytes(const std::string& bytes, std::size_t labels);
};

/// Prior for the labels of an unknown network: the mean distances and dimensions of the known ones. Fewer
/// labels have less dimensions, a third of their number, as COCO's have, and more different distances.
LabelPrior unknownLabelsPrior(std::size_t labels);

/// The prior of these labels, whatever network gives them: labels are identified by their first synonym, and
/// nine of ten must be known. Several models are put together part by part. Else unknownLabelsPrior().
LabelPrior labelPriorOf(const Vocabulary& vocabulary);

/// Reads `text`, the content of the prior file `name`. Throws Error (malformedFile, unsupportedFile).
struct NamedLabelPrior {
  std::vector<std::string> labels;
  LabelPrior prior;
};
NamedLabelPrior parseLabelPrior(const std::string& text, const std::string& name);

/// The files in models/priors, compiled in.
extern const std::string imagenetPrior, cocoPrior, places365Prior;

}  // namespace estancia
