// Class probabilities: labels restricted to target classes, with the labeler's prior corrected (thesis 6.3).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/vocabulary.hpp"
#include "estancia/objects/object_model.hpp"
#include "estancia/words/label_search.hpp"

namespace estancia {

/// p(class | image) of N samples and C target classes.
struct ClassProbabilities {
  /// N×C; a row adds up to 1, or is all 0 when the labeler gave none of the classes.
  DescriptorMatrix probabilities;
  /// N; the share of the classes in the labeler's whole answer, 0 … 1.
  std::vector<float> coverage;
};

/// One warning per label that is missing from the vocabulary, with suggestions, for classes that have another
/// known label. `source`: installedWordGraph, to suggest related labels, too.
std::vector<std::string> unknownLabels(const TargetClasses& targets, const Vocabulary& vocabulary,
                                       WordGraphSource source = nullptr);

/// Completes the classes: one that has no label in the vocabulary gets those that are kinds of what its own
/// labels name ("sofa": studio couch; findLabelKinds()), unless another class has them, by name or as fewer
/// kinds. `source`: installedWordGraph. `told`, if given, receives a sentence for each such class. Throws
/// Error (unknownName) when classes remain without a label, with near spellings and related labels, which are
/// not taken: half of them would be wrong.
TargetClasses withLabelKinds(const TargetClasses& targets, const Vocabulary& vocabulary,
                             WordGraphSource source, std::vector<std::string>* told = nullptr);

/// The labels of each class in a labeler's vocabulary.
class VocabularyMapping {
 public:
  /// Labels are found by findLabels(); one that fits two classes counts for the first. Throws Error when a
  /// class has no label in the vocabulary (unknownName, with spellings), or none of its own (invalidInput).
  VocabularyMapping(const TargetClasses& targets, const Vocabulary& vocabulary);

  /// Adds up the labels of each class, then normalizes (thesis 6.3). Throws Error as requireProbabilities().
  ClassProbabilities apply(const DescriptorMatrix& descriptors) const;

 private:
  std::size_t classes_;
  std::vector<std::size_t> classOf_;  // class of each label
};

/// VocabularyMapping for one use.
ClassProbabilities restrictTo(const TargetClasses& targets, const Vocabulary& vocabulary,
                              const DescriptorMatrix& descriptors);

/// How often the labeler gives each class: the mean of the rows that are not 0; uniform without any. Sum 1.
std::vector<float> priorOf(const ClassProbabilities& answers);

/// The probabilities for classes that are equally frequent: each divided by its `prior` (at least 0.001),
/// then normalized, as the labeler has more labels for some classes and prefers some (Saerens, Latinne,
/// Decaestecker, Neural Computation 14, 2002). Throws Error (mismatch) on a prior of other classes.
ClassProbabilities corrected(const ClassProbabilities& answers, std::span<const float> prior);

}  // namespace estancia
