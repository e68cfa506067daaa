// Object splits data: views described, labeled, and split into training and test.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "estancia/core/progress.hpp"
#include "estancia/core/vocabulary.hpp"
#include "estancia/describe/features.hpp"
#include "estancia/objects/class_probabilities.hpp"
#include "estancia/readers/object_views.hpp"
#include "objects/object_splits.hpp"

namespace estancia::experiments {

/// What is learned from, and what is asked about.
struct ObjectSplit {
  std::string name;
  /// Samples, ascending; none in both.
  std::vector<std::size_t> train, test;
};

/// All answers of a labeler for the samples.
struct ObjectLabels {
  /// Its identity.
  std::string labeler;
  Vocabulary vocabulary;
  /// A row a sample.
  DescriptorMatrix descriptors;
  /// Answers restricted to the study's classes.
  ClassProbabilities restricted;
};

/// Samples of a study's classes. Invariant: one row of shapes, class, object and group a sample.
struct ObjectTask {
  const ObjectSplitsOptions::Data* data;
  TargetClasses targets;
  std::shared_ptr<const ObjectViews> views;
  /// View of each sample.
  std::vector<std::size_t> view;
  /// Shape descriptors of all samples.
  Features shapes;
  /// The true ones.
  std::vector<int> classes;
  /// Which instance each shows, 0 …
  std::vector<int> objects;
  /// Samples that never part in validation, 0 …
  std::vector<int> groups;
  /// Names of the instances.
  std::vector<std::string> objectNames;
  /// The true one.
  std::vector<int> classOfObject;
  /// None: no labeler was asked.
  std::optional<ObjectLabels> labels;
  /// At least one; where the first is the baseline, so it is called.
  std::vector<ObjectSplit> splits;
  /// Digest of everything that learning depends on, except the split.
  std::string digest;

  bool hasBaseline() const { return splits.front().name == "baseline"; }
};

/// The tasks of all data that is there, in order; omissions are reported in `notes`. Views and labels that
/// several have in common are read once. Throws Error as splitObjects() does.
std::vector<ObjectTask> prepareTasks(const ObjectSplitsOptions& options, const ExperimentRun& run,
                                     Progress& progress, std::vector<std::string>& notes);

}  // namespace estancia::experiments
