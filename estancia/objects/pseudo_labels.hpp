// Pseudo-labels: from class probabilities to the classes that shapes are learned by; confident learning.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "estancia/classify/embedding.hpp"
#include "estancia/objects/class_probabilities.hpp"
#include "estancia/objects/training.hpp"

namespace estancia {

/// One class a sample; −1: none, not to be learned from (no probability for any class, or not trusted; voted:
/// none for the whole instance). `instances` identifies the samples of one object; `shapes` (of the same
/// samples) and `options` are for PseudoLabeling::confident alone, which equals top with fewer than two
/// classes, and keeps samples of classes that cannot be held out. Throws Error (mismatch); Interrupted.
std::vector<int> assignPseudoLabels(PseudoLabeling labeling, const ClassProbabilities& answers,
                                    std::span<const int> instances, const Features& shapes,
                                    const ClassifierOptions& options, Progress& progress = Progress::none());

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

/// Samples that are likely mislabeled (Northcutt, Jiang, Chuang, JAIR 70, 2021, section 3), ascending. A
/// sample counts for the most probable of the classes whose probability is at least the mean self-confidence
/// of that class's samples; the counts of (label, other class) estimate the number of errors, and that many
/// samples are taken (pruning by noise rate), those with the largest margin of the other class first, and
/// only where it is more probable than the label. `labels` are 0 … K − 1, `heldOut` N × K probabilities; rows
/// of zeros are not judged. Throws Error (mismatch) when the numbers of samples differ.
std::vector<std::size_t> likelyMislabeled(const std::vector<int>& labels, const DescriptorMatrix& heldOut);

}  // namespace estancia
