// Few-examples experiment: rooms by a few images of each, by their names alone, and by both.
// docs/measured/words.md reports the results.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "estancia/classify/classifier.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/findings/findings.hpp"
#include "runner/drive_grid.hpp"
#include "runner/experiment.hpp"
#include "runner/grid.hpp"
#include "runner/subjects.hpp"

namespace estancia {

class ConfigFile;

}  // namespace estancia

namespace estancia::experiments {

struct FewExamplesOptions {
  /// Names, folders, several joined by +; none: all that are installed.
  std::vector<std::string> models;
  /// Rooms in the spelling of the images' truth; names in WordNet's, "_" for a blank.
  std::vector<std::string> rooms;
  /// Images of each room that a classifier is trained on, ascending.
  std::vector<std::size_t> images{2, 3, 5, 10, 20, 40};
  /// Random draws of these, each from its own seed.
  int draws = 6;
  /// A name of classifierTypes().
  std::string classifier = ClassifierOptions().type;
  /// The name of the data that examples are drawn from.
  std::string train;
  std::vector<NamedDrive> drives;
};

/// Throws Error `file:line: …` on unknown, missing or wrong keys.
FewExamplesOptions readFewExamples(ConfigFile& config);

/// model,data,images,by,accuracy,log_loss; `by`: examples, names or both.
GridColumns fewExamplesColumns();

/// Trains and tests every draw; where the tested data is the one that examples are drawn from, on the images
/// that were not. Throws Error when a model, or data that is not optional, cannot be opened; insufficientData
/// when a room has too few images; missingDependency without WordNet.
Findings learnFromFew(const FewExamplesOptions& options, Grid& grid, const ExperimentRun& run,
                      Progress& progress);

Findings fewExamplesFindings(const DriveResults& results);

}  // namespace estancia::experiments
