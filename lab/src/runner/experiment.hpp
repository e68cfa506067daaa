// Experiments: configuration files in, findings out. One file a kind.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "estancia/core/options.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/findings/findings.hpp"
#include "estancia/label/label_stream.hpp"
#include "estancia/labelers/model.hpp"

namespace estancia {
class WorkQueue;
}

namespace estancia::experiments {

struct ExperimentRun {
  /// Where cells and results.csv go; made when it is not there.
  std::filesystem::path folder;
  /// Replace the models of the configuration; none: the configuration's.
  std::vector<std::string> models;
  /// Its threads also compute the cells; the findings do not depend on them.
  LabelerOptions labeler;
  /// Cache of answers that were paid for before.
  LabelCache* cache = nullptr;
  /// Shares the cells among processes; null: this one does all.
  WorkQueue* distribution = nullptr;
};

/// Throws Error `file:line: …` about a wrong file, as runExperiment() does before any is run.
void checkExperiments(const std::vector<std::filesystem::path>& configs);

/// Runs the experiments of the files, each of the type that it names: results.csv holds the cells of all, the
/// findings what was found of each. If there are several types, each has its own folder FOLDER/TYPE. Finished
/// cells are kept in the folder and not computed again unless something they depend on has changed. Throws
/// Error `file:line: …` about a wrong file before any is run, Interrupted when the user asks to stop, and
/// what the kind throws.
Findings runExperiment(const std::vector<std::filesystem::path>& configs, const ExperimentRun& run,
                       Progress& progress);

/// The known types.
Choices experimentTypes();

}  // namespace estancia::experiments
