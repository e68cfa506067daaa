// Training sources: folders of object views, opened with the labels of their images.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
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

/// Throws Error on a folder given twice, or fewer label files than folders (invalidOption), on a folder
/// without labels (fileNotFound), and as openObjectViews() and readDescriptors().
TrainingSources openTrainingSources(const std::vector<std::string>& folders,
                                    const std::vector<std::string>& labels, LabelSource source,
                                    const ObjectViewsOptions& options = {});

/// Each category of the views as a target class. Throws Error (insufficientData) when there is none.
TargetClasses targetClassesOf(const TrainingSources& sources);

}  // namespace estancia
