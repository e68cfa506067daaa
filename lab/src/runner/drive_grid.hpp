// Drive grid: an experiment's cells over models, drives and variants, each drive labeled once by each model.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "estancia/core/progress.hpp"
#include "estancia/findings/findings.hpp"
#include "estancia/labelers/labeler.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"
#include "findings/pivot.hpp"
#include "runner/experiment.hpp"
#include "runner/grid.hpp"
#include "runner/subjects.hpp"

namespace estancia::experiments {

/// A drive, and the words of those of its frames that could be labeled.
struct LabeledDrive {
  std::shared_ptr<const Sequence> images;
  DescriptorSequence recording;
};

/// Drives as one model sees them.
class LabeledDrives {
 public:
  LabeledDrives(Labeler& labeler, const ExperimentRun& run, Progress& progress)
      : labeler_(labeler), run_(run), progress_(progress) {}

  /// Labels it the first time that it is asked for. Throws Error as openImages() and labelAll() do.
  const LabeledDrive& of(const SequenceSource& source);

  Labeler& labeler() const { return labeler_; }
  const Vocabulary& vocabulary() const { return labeler_.vocabulary(); }
  const ExperimentRun& run() const { return run_; }
  Progress& progress() const { return progress_; }

 private:
  Labeler& labeler_;
  const ExperimentRun& run_;
  Progress& progress_;
  std::map<std::string, LabeledDrive> labeled_;  // by the digest of the images
};

/// What was found in each model's view of each drive, in each variant.
struct DriveResults {
  std::vector<std::string> models, drives, variants;
  /// cells[(model · drives + drive) · variants + variant]
  std::vector<CellResults> cells = {};

  const CellResults& of(std::size_t model, std::size_t drive, std::size_t variant = 0) const {
    return cells.at((model * drives.size() + drive) * variants.size() + variant);
  }
  /// The drive, and the model where there are several.
  std::string titleOf(std::size_t model, std::size_t drive) const {
    return models.size() == 1 ? drives[drive] : drives[drive] + ", " + models[model];
  }
  /// Calls use(model, drive): drive by drive, model by model.
  void each(const std::function<void(std::size_t model, std::size_t drive)>& use) const {
    for (std::size_t d = 0; d < drives.size(); ++d)
      for (std::size_t m = 0; m < models.size(); ++m) use(m, d);
  }
};

/// What an experiment does with each drive.
struct DriveStudy {
  /// Names, folders, several joined by +; none: all that are installed.
  const std::vector<std::string>& models;
  const std::vector<NamedDrive>& drives;
  /// Names; exactly one "": the grid has no column for them.
  std::vector<std::string> variants = {""};
  /// What cells depend on beside the images, the model and the names: a version of the computation, options.
  std::function<std::string(const NamedDrive& drive, std::size_t variant)> inputs;
  std::function<CellResults(LabeledDrives& labeled, const NamedDrive& drive, std::size_t variant)> compute;
  /// The grid's columns of a variant, where its name is not the only one.
  std::function<std::vector<std::string>(std::size_t variant)> coordinates = {};
};

/// Computes all cells, and adds the models and what was left out to what findingsOf() makes of them. Throws
/// Error when a model, or a drive that is not optional, cannot be opened, and what compute() throws.
Findings studyDrives(const DriveStudy& study,
                     const std::function<Findings(const DriveResults& results)>& findingsOf, Grid& grid,
                     const ExperimentRun& run, Progress& progress);

/// The columns of those measures that any of the cells has at "".
std::vector<Measure<CellResults>> measuresIn(
    const std::vector<CellResults>& cells,
    const std::vector<std::pair<std::string, ResultTable::Column>>& columns);

}  // namespace estancia::experiments
