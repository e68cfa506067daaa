// Object splits results: accuracies as tables, curves, word clouds and images.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "estancia/findings/findings.hpp"
#include "objects/object_splits_data.hpp"
#include "scenes/scene_answers.hpp"

namespace estancia::experiments {

/// A classifier that learns by one kind of names.
struct ObjectMethod {
  std::string classifier;
  PseudoLabeling pseudoLabeling = PseudoLabeling::top;
  /// "svm-rbf voted".
  std::string name() const;
};

std::vector<ObjectMethod> methodsOf(const ObjectSplitsOptions::Trials& trials);

/// What one method answered to one split at one noise.
struct ObjectAnswers {
  double accuracy = 0;
  /// A class of each test sample, for each seed.
  SceneAnswers answers;
};

struct ObjectSplitsResults {
  const ObjectTask* task = nullptr;
  std::vector<ObjectMethod> methods;
  /// [split][test sample]: the labeler's class, −1: none; empty: not asked.
  std::vector<std::vector<int>> labeled;
  /// The labeler's class of the first split's training samples, likewise.
  std::vector<int> learnedFrom;
  /// [(method · noises + noise) · splits + split].
  std::vector<ObjectAnswers> cells;
  /// The thesis' accuracies beside, where the protocol is its.
  bool thesisTables = false;

  std::size_t indexOf(std::size_t method, std::size_t noise, std::size_t split) const {
    return (method * task->data->trials.noises.size() + noise) * task->splits.size() + split;
  }
  double accuracy(std::size_t method, std::size_t noise, std::size_t split) const {
    return cells[indexOf(method, noise, split)].accuracy;
  }
  /// Share of the split's test samples that the labeler names rightly; absent where none was asked.
  std::optional<double> labelerAccuracy(std::size_t split) const;
};

/// The test of a split: classes for rooms, objects for runs.
SceneTest testOf(const ObjectTask& task, const ObjectSplit& split);

/// Tables and figures of one task, appended.
void addFindings(const ObjectSplitsResults& results, Findings& findings);

/// One sentence: how well the best method does beside the labeler.
std::string summaryOf(const ObjectSplitsResults& results);

}  // namespace estancia::experiments
