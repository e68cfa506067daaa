// Labeled shapes and their held-out predictions, shared by pseudo-labels and object models.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "estancia/classify/classifier.hpp"
#include "estancia/classify/embedding.hpp"
#include "estancia/describe/features.hpp"

namespace estancia {

/// The samples that have a word.
struct NamedShapes {
  std::vector<std::size_t> rows;  ///< which they are
  FeatureEmbedding embedding;     ///< learned from them
  Samples samples;                ///< classes are words, groups things (instanceGroups())
};

/// Those whose word is not −1, of a study of `count` words. Throws Error when the numbers of shapes, words
/// and instances differ, a word is none of 0 … count − 1, or as FeatureEmbedding::learn() does, as when there
/// are none.
NamedShapes namedShapes(const Features& shapes, std::span<const int> words, std::span<const int> instances,
                        std::size_t count, int folds);

/// Class probabilities of each sample by a classifier trained on the other folds; all 0 if these lack the
/// sample's class, so that it could only be wrong. C is 10 and gamma 1 unless given: they are not searched
/// for. Throws Error as trainClassifier(); Interrupted.
DescriptorMatrix heldOut(const Samples& samples, const ClassifierOptions& options,
                         Progress& progress = Progress::none());

}  // namespace estancia
