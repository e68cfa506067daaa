// Object training: self-supervised learning of 3-D shapes from an image classifier's labels (thesis 6.3).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "estancia/classify/classifier.hpp"
#include "estancia/core/options.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/describe/features.hpp"
#include "estancia/objects/object_model.hpp"
#include "estancia/readers/object_views.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"

namespace estancia {

struct OwnClasses;

/// How class probabilities become pseudo-labels.
enum class PseudoLabeling {
  /// The most probable class of each sample (thesis 6.3).
  top,
  /// One class an instance, from the fused probabilities of all its samples.
  voted,
  /// Like top, without samples that held-out shape classifiers contradict (confident learning; Northcutt,
  /// Jiang, Chuang, JAIR 70, 2021).
  confident
};

/// The names of PseudoLabeling.
Choices pseudoLabelings();
/// Throws Error (unknownName).
PseudoLabeling getPseudoLabeling(const std::string& name);

/// Views of objects with the labels of their images; without labels, their true categories are learned.
struct LabeledViews {
  const ObjectViews* views = nullptr;
  std::optional<DescriptorSequence> labels = {};
};

struct TrainingOptions {
  PseudoLabeling pseudoLabels = PseudoLabeling::voted;
  bool correctPrior = true;
  double minCoverage = 0;
  bool allViews = false;
  std::string split = {};
  ShapeOptions shape = {};
  ClassifierOptions classifier = {};
};
OptionGroup declare(TrainingOptions& options);

/// Training data. Invariant: one class and one instance a row of `shapes`.
struct ObjectTraining {
  TargetClasses targets;
  /// Options of `shapes`.
  ShapeOptions shape;
  Features shapes;
  /// Index of the target class; −1 is left out.
  std::vector<int> classes;
  /// Samples of one instance are never split in cross-validation.
  std::vector<int> instances;
  /// Identity of the labeler; "" for a person.
  std::string labeler;
  /// How often that labeler gives each class (priorOf()); empty: answers are taken as they are.
  std::vector<float> prior;
};

/// Training data with statistics for people.
struct TrainingSet {
  ObjectTraining training;
  /// Number for each class.
  std::vector<std::size_t> samples = {}, instances = {};
  /// Views that were left out: flat ones, and those cut by the image border.
  std::size_t flat = 0, atBorder = 0;
  /// Views without labels, or whose category is no target class.
  std::size_t unlabeled = 0;
  /// Views without a pseudo-label.
  std::size_t rejected = 0;
  /// Mean share of the target classes in the labeler's answers; 1 for true categories.
  double coverage = 0;
  /// Pseudo-labels of views whose category is a target class: how many there are, and how many are correct.
  std::size_t comparable = 0, correct = 0;
  /// Where no target classes were given: those that the labels make.
  std::shared_ptr<const OwnClasses> own = {};
};

/// Describes the shapes of views and gives each a class: restricts the labels to the target classes, corrects
/// the labeler's prior, and assigns pseudo-labels; trainObjectModel() learns from the result. Without
/// `targets.classes` the labels make their own (findOwnClasses()); other objects are not learned from, and
/// the prior is not corrected, as only frequent words are classes. Instances are distinct across `sources`;
/// pass each source once. Views find their labels by whole names or, if no view of a source does, as frames
/// do by RecordedLabeler. Views that cannot be described are left out; the reasons go to `problems`. Throws
/// Error (insufficientData) when no view is left or gets a class, or labels make fewer than two,
/// (unknownName) when no view belongs to the split, (mismatch) when sources have different labelers or only
/// some have labels, or other vocabularies where the classes are their own, and as restrictTo(); Interrupted.
TrainingSet gatherTraining(std::span<const LabeledViews> sources, const TargetClasses& targets,
                           const TrainingOptions& options = {}, Progress& progress = Progress::none(),
                           std::vector<std::string>* problems = nullptr);

/// Throws Error (insufficientData) when fewer than two classes have samples, and as trainClassifier();
/// Interrupted.
ObjectModel trainObjectModel(const ObjectTraining& training, const ClassifierOptions& options = {},
                             Progress& progress = Progress::none());

/// The categories of the views: the target classes if there are no others.
std::vector<std::string> categoriesOf(std::span<const LabeledViews> sources);

}  // namespace estancia
