// Model choice experiment: the thesis' variance inside clusters (4.5.2, Table 4.1, Fig. 4.4 and 4.5), and
// place recognition. docs/measured/model-choice.md explains the measures.
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
#include "estancia/sequences/sequence.hpp"
#include "runner/experiment.hpp"
#include "runner/grid.hpp"
#include "runner/subjects.hpp"

namespace estancia {

class ConfigFile;

}  // namespace estancia

namespace estancia::experiments {

struct ModelChoiceOptions {
  struct Drive {
    /// For people; default: the folder's.
    std::string name;
    SequenceSource images;
    /// Left out, with a note, when it is not there.
    bool optional = false;
    /// A second visit to these places: the queries of place recognition.
    std::optional<SequenceSource> again;
    /// Images this near show the same place [m]; 0: a quarter of the spread of the positions (the root of
    /// their variance).
    double radius = 0;
    /// Without `again`: images nearer in time than this share of the drive's frames are no answers.
    double gap = 0.05;
  };

  /// Names or folders; none: all that are installed.
  std::vector<std::string> models;
  /// At least one, all with poses.
  std::vector<Drive> sequences;
  /// How descriptors are compared; each gives its own ranking, the first one the answer. Only distances whose
  /// vectors k-means can average: Euclidean ones and cosines.
  std::vector<std::string> distances{"standardized-clr"};
  /// K = 1 … this.
  std::size_t clusters = 50;
  /// The k of the tables.
  std::vector<std::size_t> shown{7, 15, 30, 50};
  /// K-means begins at random: variances are the mean of so many clusterings.
  std::size_t repeats = 10;
  /// Seed of the first repetition; the others follow.
  std::size_t seed = 1;
  /// The thesis' Table 4.1 beside.
  bool thesisTables = false;
};

/// Throws Error `file:line: …` on unknown, missing or wrong keys.
ModelChoiceOptions readModelChoice(ConfigFile& config);

/// The columns of its results.csv. Places have no k: they stand in a row of their own.
GridColumns modelChoiceColumns();

/// Runs the experiment. Throws Error when a named model or a sequence that is not optional cannot be opened,
/// a sequence has no poses, or nothing is left to compare.
Findings chooseModel(const ModelChoiceOptions& options, Grid& grid, const ExperimentRun& run,
                     Progress& progress);

}  // namespace estancia::experiments
