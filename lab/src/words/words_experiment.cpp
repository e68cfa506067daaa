// SPDX-License-Identifier: Apache-2.0
#include "words/words_experiment.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>

#include "estancia/core/config.hpp"
#include "estancia/core/error.hpp"
#include "estancia/labelers/model.hpp"
#include "runner/config_lists.hpp"
#include "runner/subjects.hpp"
#include "words/average_precision.hpp"
#include "words/label_finders.hpp"
#include "words/word_queries.hpp"

namespace estancia::experiments {
namespace {

WordNet readInstalledWordNet() {
  const auto folder = findWordNet();
  if (!folder)
    throw Error(
        ErrorCode::missingDependency,
        "no WordNet in $ESTANCIA_WORDNET, else /usr/share/wordnet; install it (Debian: wordnet-base)");
  return readWordNet(*folder);
}

WordAnswer ask(const WordQuery& query, const LabelFinders& finders, std::size_t labels) {
  WordAnswer answer{query.kind, query.text, query.answers.size(), {}, 0, 0, 0};
  for (std::size_t method = 0; method < LabelFinders::methods().size(); ++method)
    answer.averagePrecisions.push_back(averagePrecision(finders.score(method, query.text), query.answers));
  for (const LabelMatch& match : finders.search().search(query.text, labels).labels) {
    ++answer.returned;
    answer.correct += std::ranges::binary_search(query.answers, match.label) ? 1 : 0;
  }
  const auto start = std::chrono::steady_clock::now();
  finders.search().search(query.text);
  const std::chrono::duration<double, std::milli> taken = std::chrono::steady_clock::now() - start;
  answer.milliseconds = taken.count();
  return answer;
}

const char* halfOf(std::size_t query) {
  return query % 2 == 0 ? "even" : "odd";
}

void addRows(const std::string& model, const std::vector<WordAnswer>& answers, Grid& grid) {
  for (std::size_t q = 0; q < answers.size(); ++q) {
    const WordAnswer& answer = answers[q];
    CellResults results;
    for (std::size_t m = 0; m < answer.averagePrecisions.size(); ++m) {
      const std::string& method = LabelFinders::methods()[m].name;
      results.push_back({"answers", method, static_cast<double>(answer.answers)});
      results.push_back({"average_precision", method, answer.averagePrecisions[m]});
    }
    const std::string& search = LabelFinders::methods().back().name;
    results.push_back({"returned", search, static_cast<double>(answer.returned)});
    results.push_back({"correct", search, static_cast<double>(answer.correct)});
    results.push_back({"milliseconds", search, answer.milliseconds});
    grid.add({model, halfOf(q), answer.kind, answer.query}, results);
  }
}

}  // namespace

WordsOptions readWords(ConfigFile& config) {
  WordsOptions options;
  config.read(
      {{"type", true, "the kind of experiment", [](auto&) {}},
       {"queries", true, "a CSV kind,query,labels", [&](auto& n) { options.queries = config.anywhere(n); }},
       {"models", false, "the models whose labels are looked for",
        each(config, options.models, [&config](auto& n) { return config.text(n); })}});
  return options;
}

GridColumns wordsColumns() {
  return {{"model", "half", "kind", "query"},
          "method",
          {"answers", "average_precision", "returned", "correct", "milliseconds"}};
}

Findings compareWords(const WordsOptions& options, Grid& grid, const ExperimentRun& run, Progress& progress) {
  Findings findings;
  std::vector<std::string> models = options.models;
  if (models.empty()) models.push_back(defaultModel);
  std::optional<WordNet> wordNet;
  for (const Candidate& model : modelsToCompare(models, run, findings.notes)) {
    LabelerOptions labels = run.labeler;
    labels.onDemand = true;
    const auto labeler = loadModel(model.model, labels);
    const Vocabulary& vocabulary = labeler->vocabulary();
    const std::vector<WordQuery> queries = readWordQueries(options.queries, vocabulary);
    if (!wordNet) wordNet = readInstalledWordNet();
    const LabelFinders finders(vocabulary, *wordNet);
    std::vector<WordAnswer> answers;
    progress.begin("asking for labels of " + model.name, queries.size());
    for (const WordQuery& query : queries) {
      if (interrupted()) throw Interrupted("stopped between two queries; the next run begins anew");
      answers.push_back(ask(query, finders, vocabulary.size()));
      progress.advance();
    }
    progress.end();
    addRows(model.name, answers, grid);
    Findings own = wordsFindings(model.name, answers);
    findings.title = own.title;
    findings.summary += (findings.summary.empty() ? "" : " ") + own.summary;
    findings.facts.emplace_back("Model", labeler->identity());
    findings.facts.insert(findings.facts.end(), own.facts.begin(), own.facts.end());
    for (auto& section : own.sections) findings.sections.push_back(std::move(section));
  }
  return findings;
}

}  // namespace estancia::experiments
