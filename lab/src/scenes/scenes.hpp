// Scene classification experiment: every descriptor with every classifier, learned on some images and tested
// on others (thesis 3.5: Fig. 3.7 to 3.11, Table 3.2). docs/measured/scenes.md shows the tables that it
// makes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "estancia/core/progress.hpp"
#include "estancia/findings/findings.hpp"
#include "runner/experiment.hpp"
#include "runner/grid.hpp"
#include "runner/subjects.hpp"

namespace estancia {

class ConfigFile;

}  // namespace estancia

namespace estancia::experiments {

struct ScenesOptions {
  /// Images (or a table of features) whose rooms are known. With a `splitColumn`, or with `test`, they are
  /// learned from and asked about in one pair; else they are a sequence that makes a pair with every other.
  struct Data {
    std::string name;
    SequenceSource images;
    /// CSV with a header, one line an image; "": the images know their rooms.
    std::filesystem::path table;
    std::string imageColumn = "image", roomColumn = "room";
    /// Column of the table; "": all images belong together.
    std::string splitColumn;
    /// Its values.
    std::string train = "train", test = "test";
    /// The images to ask about: [data.test].
    std::optional<SequenceSource> asked;
    /// These rooms; none: all.
    std::vector<std::string> only;
    /// Columns of a table of features that are none.
    std::vector<std::string> ignored;
    /// Left out, with a note, when it is not there.
    bool optional = false;
  };
  /// A descriptor in fewer labels (3.5.3, Fig. 3.11).
  struct Subsets {
    std::string descriptor, classifier;
    /// How many labels; 0: all.
    std::vector<std::size_t> counts;
    /// The rules that choose them, on the training images alone.
    std::vector<std::string> by;
  };

  /// Name of the study: the file's.
  std::string name;
  /// Parts are joined by +: "inception-v3+gist".
  std::vector<std::string> descriptors;
  /// Left out, with a note, where a model is not installed.
  std::vector<std::string> optionalDescriptors;
  /// None: all.
  std::vector<std::string> classifiers;
  /// Each cell is the mean over them.
  std::vector<std::uint64_t> seeds{1};
  /// Folds of the cross-validation in which classifiers choose their parameters.
  int folds = 5;
  /// Also pairs of a sequence with itself (without a split).
  bool sameSequence = true;
  std::optional<Subsets> subsets;
  /// The thesis' Table 3.2 beside.
  bool thesisTables = false;
  /// A sequence of `data` whose pairs with others are also shown and ranked alone (Fig. 3.9, 3.10).
  std::string focus;
  /// At least one.
  std::vector<Data> data;
};

/// Throws Error `file:line: …` on unknown, missing or wrong keys.
ScenesOptions readScenes(ConfigFile& config);

/// descriptor,classifier,train,test,accuracy,balanced_accuracy,accuracy_low,accuracy_high
GridColumns scenesColumns();

/// Runs the experiment. Beside the grid's results it writes NAME-confusions.csv, NAME-images.csv (how often
/// each image was taken for another room), NAME-scores.csv (what the ranks are made of, for `estancia
/// compare`) and, where subsets are asked for, NAME-subsets.csv. Throws Error
/// when a descriptor is unknown, data that is not optional cannot be opened, or a training half shows fewer
/// than two rooms or a room in one image only.
Findings compareScenes(const ScenesOptions& options, Grid& grid, const ExperimentRun& run,
                       Progress& progress);

}  // namespace estancia::experiments
