// Experiments: a configuration file in, findings out. One file a kind.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "estancia/core/findings.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/label/label_cache.hpp"
#include "estancia/label/model.hpp"

namespace estancia {

struct ExperimentRun {
  std::filesystem::path folder;     ///< where cells and results.csv go; made when it is not there
  std::vector<std::string> models;  ///< instead of those of the configuration; none: as it says
  LabelerOptions labeler;       ///< its threads also compute the cells; the findings do not depend on them
  LabelCache* cache = nullptr;  ///< of words that were paid for before
};

/// Runs the experiment that the file's `type` names. Finished cells are kept in the folder and not computed
/// again unless something they depend on has changed.
/// Throws Error `file:line: …` about a wrong file, Interrupted when the user asks to stop, and what the kind
/// throws.
Findings runExperiment(const std::filesystem::path& config, const ExperimentRun& run, Progress& progress);

/// The known types, each with one line of explanation.
std::vector<std::pair<std::string, std::string>> experimentTypes();

}  // namespace estancia
