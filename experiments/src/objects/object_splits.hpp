// Shapes learned by the names that a labeler gives, asked about things or views that were not learned from
// (thesis 6.4: Fig. 6.3, 6.6 and 6.7, Tables 6.7 and 6.8). docs/measured/objects.md shows the tables that
// it makes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "estancia/core/progress.hpp"
#include "estancia/io/object_views.hpp"
#include "estancia/objects/shape.hpp"
#include "estancia/objects/training.hpp"
#include "experiments/src/findings/findings.hpp"
#include "experiments/src/objects/label_noise.hpp"
#include "experiments/src/runner/experiment.hpp"
#include "experiments/src/runner/grid.hpp"

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
    std::vector<double> noises{0};        ///< shares of training samples that are misnamed on purpose
    std::vector<std::uint64_t> seeds{1};  ///< of noise and learning; each accuracy is the mean over them
  };
  enum class Split {
    instances,  ///< the thesis': of each word one thing is tested; the worst labeled ones, then at random
    views,      ///< a third of the views of each thing, one after the other
    official    ///< the data set's own
  };
  struct Data {
    std::string name;
    std::filesystem::path views;
    ObjectViewsOptions reading;
    std::filesystem::path study;  ///< "": each category is a word
    Split split = Split::instances;
    bool machineNames = true;      ///< learned from; else the true ones are
    std::filesystem::path labels;  ///< what a labeler says of the views: a recording …
    std::string model;             ///< … or who is asked; neither: no labeler
    bool prior = true;             ///< the labeler's answers are corrected by its prior
    NoiseKind noise = NoiseKind::view;
    ShapeOptions shape;
    Trials trials;
    bool optional = false;  ///< left out, with a note, when it is not there
  };
  std::size_t splits = 30;  ///< at random
  std::uint64_t splitSeed = 1;
  int folds = 5;  ///< of the cross-validation in which classifiers choose their parameters
  std::vector<Data> data;
};

/// Throws Error `file:line: …` on unknown, missing or wrong keys.
ObjectSplitsOptions readObjectSplits(ConfigFile& config);

/// data,split,labeler_accuracy,classifier,label_noise,accuracy
GridColumns objectSplitsColumns();

/// Runs the experiment. Throws Error when data that is not optional cannot be opened, views show one word
/// alone, cannot be split as asked, or have no words in `labels`; and when no word of the study is ever said.
Findings splitObjects(const ObjectSplitsOptions& options, Grid& grid, const ExperimentRun& run,
                      Progress& progress);

}  // namespace estancia::experiments
