// Views of things and what a labeler or a data set calls them → what a model is learned from.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "estancia/classify/classifier.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/io/descriptor_sequence.hpp"
#include "estancia/io/object_views.hpp"
#include "estancia/objects/object_model.hpp"
#include "estancia/objects/pseudo_labels.hpp"
#include "estancia/objects/shape.hpp"
#include "estancia/objects/target_classes.hpp"

namespace estancia {

/// Views with the words for their images; without words they go by their true categories.
struct LabeledViews {
  const ObjectViews* views = nullptr;
  std::optional<DescriptorSequence> words = {};
};

struct TrainingOptions {
  PseudoLabeling naming =
      PseudoLabeling::voted;  ///< how words become names; true categories are names already
  bool correct = true;        ///< for how often the labeler says each word: corrected()
  bool all = false;  ///< also flat views and those cut by the border, which show not the thing's shape
  /// Things of whose images the labeler says less than this about the words, in the mean over their views,
  /// are none of the study's and get no name; 0 … 1.
  double leastMass = 0;
  std::string split = {};  ///< only the views of this part of the data; "": all
  ShapeOptions shape = {};
  ClassifierOptions classifier = {};  ///< for Naming::confident
};

/// What is learned from, and what is not, for people.
struct TrainingSet {
  ObjectTraining training;
  std::vector<std::size_t> samples, instances;  ///< of each word
  std::size_t flat = 0, atBorder = 0;           ///< views that were left out as they are
  std::size_t without = 0;                      ///< views without words, or of a category that is no word
  std::size_t unnamed = 0;                      ///< views that got no name from what was said of them
  double mass = 0;  ///< mean of what the labeler's answers say of the words; 1 for true categories
  /// Of the named views whose category is a word of the study: how many there are, and are named by it.
  std::size_t checked = 0, right = 0;
};

/// Instances of different `sources` are different ones: give each once. Views find their words by whole names
/// or, where no view of a source does, as frames do by RecordedLabeler. Those that cannot be described are
/// told in `problems` and left out. Throws Error when no view is left or named, saying why, when no view is
/// of the split, when sources were labeled by different labelers, only some have words, and as restrictTo()
/// does; Interrupted.
TrainingSet gatherTraining(std::span<const LabeledViews> sources, const TargetClasses& study,
                           const TrainingOptions& options, Progress& progress,
                           std::vector<std::string>* problems = nullptr);

/// The categories of the views, which are the words when nobody gives a study.
std::vector<std::string> categoriesOf(std::span<const LabeledViews> sources);

}  // namespace estancia
