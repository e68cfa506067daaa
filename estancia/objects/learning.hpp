// Labeled shapes: training samples and their held-out predictions, for pseudo-labels and object models.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "estancia/classify/classifier.hpp"
#include "estancia/classify/embedding.hpp"
#include "estancia/describe/features.hpp"

namespace estancia {

/// The samples that have a class.
struct LabeledShapes {
  std::vector<std::size_t> rows;
  /// Learned from them.
  FeatureEmbedding embedding;
  /// The groups are instances (instanceGroups()).
  Samples samples;
};

/// The samples whose class is not −1, of `count` classes. Throws Error (mismatch) when the numbers of shapes,
/// classes and instances differ, (invalidInput) when a class is none of 0 … count − 1, and as
/// FeatureEmbedding::learn(), as without any sample.
LabeledShapes labeledShapes(const Features& shapes, std::span<const int> classes,
                            std::span<const int> instances, std::size_t count, int folds);

/// Class probabilities of each sample by a classifier trained on the other folds; all 0 if these lack the
/// sample's class, so that it could only be wrong. C is 10 and gamma 1 unless given: they are not searched
/// for. Throws Error as trainClassifier(); Interrupted.
DescriptorMatrix heldOut(const Samples& samples, const ClassifierOptions& options,
                         Progress& progress = Progress::none());

}  // namespace estancia
