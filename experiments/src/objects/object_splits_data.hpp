// Views of things for a study of splits: described, named by a labeler, and parted.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "estancia/core/progress.hpp"
#include "estancia/core/vocabulary.hpp"
#include "estancia/describe/features.hpp"
#include "estancia/io/object_views.hpp"
#include "estancia/objects/class_probabilities.hpp"
#include "experiments/src/objects/object_splits.hpp"

namespace estancia::experiments {

/// What is learned from, and what is asked about.
struct ObjectSplit {
  std::string name;
  std::vector<std::size_t> train, test;  ///< samples, ascending; none in both
};

/// All that a labeler says of the samples.
struct ObjectWords {
  std::string labeler;  ///< its identity
  Vocabulary vocabulary;
  DescriptorMatrix descriptors;   ///< a row a sample
  ClassProbabilities restricted;  ///< of the study's words, as they are
};

/// Samples of a study's words. Invariant: one row of shapes, word, thing and group a sample.
struct ObjectTask {
  const ObjectSplitsOptions::Data* data;
  TargetClasses targets;
  std::shared_ptr<const ObjectViews> views;
  std::vector<std::size_t> view;        ///< of each sample
  Features shapes;                      ///< of all samples
  std::vector<int> words;               ///< the true ones
  std::vector<int> things;              ///< which instance each shows, 0 …
  std::vector<int> groups;              ///< samples that never part in validation, 0 …
  std::vector<std::string> thingNames;  ///< of instances
  std::vector<int> wordOfThing;         ///< the true one
  std::optional<ObjectWords> said;      ///< none: no labeler was asked
  std::vector<ObjectSplit> splits;      ///< at least one; where the first is the baseline, so it is called
  std::string digest;                   ///< of all that learning depends on, but the split

  bool hasBaseline() const { return splits.front().name == "baseline"; }
};

/// The tasks of all data that is there, in order; what is left out is told in `notes`. Views and words that
/// several have in common are read once. Throws Error as splitObjects() does.
std::vector<ObjectTask> prepareTasks(const ObjectSplitsOptions& options, const ExperimentRun& run,
                                     Progress& progress, std::vector<std::string>& notes);

}  // namespace estancia::experiments
