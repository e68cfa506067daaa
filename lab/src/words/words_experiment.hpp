// Words experiment: how well the labels that people mean are found by their own words, method by method.
// docs/measured/words.md reports the results.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "estancia/core/progress.hpp"
#include "estancia/findings/findings.hpp"
#include "runner/experiment.hpp"
#include "runner/grid.hpp"

namespace estancia {

class ConfigFile;

}  // namespace estancia

namespace estancia::experiments {

struct WordsOptions {
  /// See readWordQueries().
  std::filesystem::path queries;
  /// Names, folders, several joined by +; none: the default model.
  std::vector<std::string> models;
};

/// What was found for one query.
struct WordAnswer {
  std::string kind, query;
  std::size_t answers = 0;
  /// One a method of LabelFinders.
  std::vector<double> averagePrecisions;
  /// Labels that search returns, and those of them that are answers.
  std::size_t returned = 0, correct = 0;
  /// Duration of one search, done as by the command.
  double milliseconds = 0;
};

/// Throws Error `file:line: …` on unknown, missing or wrong keys.
WordsOptions readWords(ConfigFile& config);

/// model,half,kind,query,method,answers,average_precision,returned,correct,milliseconds
GridColumns wordsColumns();

/// Asks every query of every method of LabelFinders. Nothing is kept for the next run: all of it takes
/// seconds. Throws Error when a model or a query is wrong, and (missingDependency) without WordNet.
Findings compareWords(const WordsOptions& options, Grid& grid, const ExperimentRun& run, Progress& progress);

/// Findings of one model; the queries in their order: the weights of the methods were chosen on the even
/// ones, from 0.
Findings wordsFindings(const std::string& model, const std::vector<WordAnswer>& answers);

}  // namespace estancia::experiments
