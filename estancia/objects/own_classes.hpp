// Own classes: the words that several objects surely have become target classes where no study names any.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "estancia/classify/classifier.hpp"
#include "estancia/core/descriptor.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/core/vocabulary.hpp"
#include "estancia/describe/features.hpp"
#include "estancia/objects/object_model.hpp"
#include "estancia/words/installed_words.hpp"

namespace estancia {

/// A word, and the objects that surely have it.
struct SureWord {
  std::string name;
  /// Labels that it stands for, the most probable first; several where a concept joins them.
  std::vector<std::size_t> labels;
  std::size_t objects = 0, views = 0;
  /// Its mean probability for these objects.
  double probability = 0;
  /// Objects whose shapes have this word by a classifier that has not seen them, and the probability of as
  /// many by chance; of words of one object, which cannot be held out, 1.
  std::size_t recognized = 0;
  double chance = 1;
};

struct OwnClasses {
  /// The word of most objects first.
  std::vector<SureWord> classes;
  /// Other words that objects surely have.
  std::vector<SureWord> leftOut;
  /// Index in `classes` of each sample's object; −1: none.
  std::vector<int> classOf;
  /// Objects of which no word is more probable than all others together.
  std::size_t unsure = 0;
};

/// Words become classes by two witnesses, image and shape (co-training: Blum & Mitchell 1998).
///  1. The answers for all views of an object are fused by their mean (linear opinion pool: Stone 1961). It
///     surely has a word of which the probability is above `minProbability`, at least 0.5: more than all
///     others together.
///  2. A classifier learns the shapes of the words of two objects or more from all objects but some, and is
///     asked about these. Its answers must agree with the word's more often than by chance: Fisher's exact
///     test, with 5 % of the classes expected to pass by chance (Benjamini & Hochberg 1995).
/// `labels` is N × vocabulary; `instances` are the objects of these N samples, and `shapes` theirs;
/// `concepts` join labels (familiarWords()). Throws Error (mismatch) when their numbers differ; Interrupted.
OwnClasses findOwnClasses(const Vocabulary& vocabulary, const LabelConcepts& concepts,
                          const DescriptorMatrix& labels, const std::vector<int>& instances,
                          const Features& shapes, const ClassifierOptions& options,
                          double minProbability = 0.5, Progress& progress = Progress::none());

/// Each class by its word, with its labels, and the categories of these names.
TargetClasses targetClassesOf(const OwnClasses& own, const Vocabulary& vocabulary);

/// What is no class and why: "3 objects have no sure word; too rare, of one object each: desk, plane; …".
std::string leftOutOf(const OwnClasses& own);

}  // namespace estancia
