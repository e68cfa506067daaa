// Training sources: folders of object views, opened with the labels of their images.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "estancia/objects/training.hpp"
#include "estancia/readers/object_views.hpp"

namespace estancia {

struct TrainingSources {
  std::vector<std::unique_ptr<ObjectViews>> views;
  /// One for each of `views`, as gatherTraining() takes them.
  std::vector<LabeledViews> labeled;
};

/// Where the labels of the views come from.
enum class LabelSource {
  /// The given label files, one a folder in order; without any, words.labels in the folders.
  files,
  /// No labels: the categories of the data set are learned.
  categories,
};

/// Throws Error (invalidOption) when a folder is given twice, or not as many label files as folders;
/// (fileNotFound) when a folder has no labels; and as openObjectViews() and readDescriptors().
TrainingSources openTrainingSources(const std::vector<std::string>& folders,
                                    const std::vector<std::string>& labels, LabelSource source,
                                    const ObjectViewsOptions& options = {});

/// Each category of the views as a target class. Throws Error (insufficientData) when there is none.
TargetClasses targetClassesOf(const TrainingSources& sources);

}  // namespace estancia
