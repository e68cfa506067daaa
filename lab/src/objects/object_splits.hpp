// Object splits experiment: shapes learned from pseudo-labels, tested on other instances or views
// (thesis 6.4: Fig. 6.3, 6.6 and 6.7, Tables 6.7 and 6.8). docs/measured/objects.md shows the tables that it
// makes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "estancia/core/progress.hpp"
#include "estancia/findings/findings.hpp"
#include "estancia/objects/pseudo_labels.hpp"
#include "estancia/objects/shape.hpp"
#include "estancia/objects/training.hpp"
#include "estancia/readers/object_views.hpp"
#include "objects/label_noise.hpp"
#include "runner/experiment.hpp"
#include "runner/grid.hpp"

namespace estancia {

class ConfigFile;

}  // namespace estancia

namespace estancia::experiments {

struct ObjectSplitsOptions {
  /// What is tried on some data.
  struct Trials {
    std::vector<PseudoLabeling> pseudoLabelings{PseudoLabeling::top, PseudoLabeling::voted,
                                                PseudoLabeling::confident};
    std::vector<std::string> classifiers{"svm-rbf"};
    /// Shares of training samples that are misnamed on purpose.
    std::vector<double> noises{0};
    /// Seeds of noise and learning; each accuracy is the mean over them.
    std::vector<std::uint64_t> seeds{1};
  };
  enum class Split {
    /// The thesis': one instance of each class is tested; the worst labeled ones, then at random.
    instances,
    /// A third of the views of each instance, one after the other.
    views,
    /// The data set's own.
    official
  };
  struct Data {
    std::string name;
    std::filesystem::path views;
    ObjectViewsOptions reading;
    /// "": each category is a class.
    std::filesystem::path study;
    Split split = Split::instances;
    /// Learned from; else the true ones are.
    bool machineNames = true;
    /// A labeler's answers for the views: a recording.
    std::filesystem::path labels;
    /// Or who is asked; neither: no labeler.
    std::string model;
    /// The labeler's answers are corrected by its prior.
    bool prior = true;
    NoiseKind noise = NoiseKind::view;
    ShapeOptions shape;
    Trials trials;
    /// Left out, with a note, when it is not there.
    bool optional = false;
  };
  /// At random.
  std::size_t splits = 30;
  std::uint64_t splitSeed = 1;
  /// Folds of the cross-validation in which classifiers choose their parameters.
  int folds = 5;
  /// The thesis' accuracies beside.
  bool thesisTables = false;
  std::vector<Data> data;
};

/// Throws Error `file:line: …` on unknown, missing or wrong keys.
ObjectSplitsOptions readObjectSplits(ConfigFile& config);

/// data,split,labeler_accuracy,classifier,label_noise,accuracy
GridColumns objectSplitsColumns();

/// Runs the experiment. Throws Error when data that is not optional cannot be opened, views show one class
/// alone, cannot be split as asked, or have no labels in `labels`; and when no class of the study is ever
/// among the labels.
Findings splitObjects(const ObjectSplitsOptions& options, Grid& grid, const ExperimentRun& run,
                      Progress& progress);

}  // namespace estancia::experiments
