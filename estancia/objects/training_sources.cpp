// SPDX-License-Identifier: Apache-2.0
#include "estancia/objects/training_sources.hpp"

#include <filesystem>

#include "estancia/core/fail.hpp"
#include "estancia/readers/object_samples.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;

/// An object that is there twice would be two instances, one of them held out while the other is learned.
void requireDifferent(const std::vector<std::string>& folders) {
  for (std::size_t i = 0; i < folders.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (std::error_code none; fs::equivalent(folders[i], folders[j], none))
        fail(ErrorCode::invalidOption, "{} and {} are the same folder; give it once", folders[j], folders[i]);
}

DescriptorSequence labelsOf(const std::string& folder) {
  if (!isObjectSamples(folder))
    fail(ErrorCode::fileNotFound,
         "{} is no folder of `estancia objects collect`: run `estancia objects label {} -o NAME.labels`, "
         "then give --recorded-labels NAME.labels, or learn the true categories by --truth",
         folder, folder);
  if (!fs::exists(labelFileOf(folder)))
    fail(ErrorCode::fileNotFound,
         "{} has no labels yet: run `estancia objects label {}`, give --recorded-labels, or learn the true "
         "categories by --truth",
         folder, folder);
  return readDescriptors(labelFileOf(folder));
}

}  // namespace

TrainingSources openTrainingSources(const std::vector<std::string>& folders,
                                    const std::vector<std::string>& labels, LabelSource source,
                                    const ObjectViewsOptions& options) {
  requireDifferent(folders);
  if (!labels.empty() && labels.size() != folders.size())
    fail(ErrorCode::invalidOption,
         "{} folders of views need as many --recorded-labels, in the same order; there are {}",
         folders.size(), labels.size());
  TrainingSources sources;
  for (std::size_t i = 0; i < folders.size(); ++i) {
    sources.views.push_back(openObjectViews(folders[i], options));
    LabeledViews& labeled = sources.labeled.emplace_back();
    labeled.views = sources.views.back().get();
    if (source == LabelSource::files)
      labeled.labels = labels.empty() ? labelsOf(folders[i]) : readDescriptors(labels[i]);
  }
  return sources;
}

TargetClasses targetClassesOf(const TrainingSources& sources) {
  const auto categories = categoriesOf(sources.labeled);
  if (categories.empty())
    fail(ErrorCode::insufficientData,
         "{}: no view has a category; fill in the column `category` of samples.csv, or train on labels",
         sources.views.front()->name());
  return targetClassesOf(categories);
}

}  // namespace estancia
