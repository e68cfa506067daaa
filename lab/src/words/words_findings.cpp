// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "findings/pivot.hpp"
#include "words/label_finders.hpp"
#include "words/words_experiment.hpp"

namespace estancia::experiments {
namespace {

using Answers = std::vector<const WordAnswer*>;
using OfAnswer = std::function<double(const WordAnswer&)>;

/// Every second query, from the first or the second one.
Answers halfOfAnswers(const std::vector<WordAnswer>& answers, bool isOdd) {
  Answers half;
  for (std::size_t q = isOdd ? 1 : 0; q < answers.size(); q += 2) half.push_back(&answers[q]);
  return half;
}

/// Answers of each kind, in order of their first query; then all.
std::vector<std::pair<std::string, Answers>> byKind(const Answers& answers) {
  std::vector<std::pair<std::string, Answers>> kinds;
  for (const WordAnswer* answer : answers) {
    auto kind = std::ranges::find(kinds, answer->kind, [](const auto& k) { return k.first; });
    if (kind == kinds.end()) kind = kinds.insert(kind, {answer->kind, {}});
    kind->second.push_back(answer);
  }
  kinds.emplace_back("(all)", answers);
  return kinds;
}

std::vector<double> valuesOf(const Answers& answers, const OfAnswer& value) {
  std::vector<double> values;
  for (const WordAnswer* answer : answers) values.push_back(value(*answer));
  return values;
}

OfAnswer averagePrecisionBy(std::size_t method) {
  return [method](const WordAnswer& answer) { return answer.averagePrecisions[method]; };
}

double precisionOf(const WordAnswer& answer) {
  return answer.returned == 0 ? 0
                              : static_cast<double>(answer.correct) / static_cast<double>(answer.returned);
}

double recallOf(const WordAnswer& answer) {
  return static_cast<double>(answer.correct) / static_cast<double>(answer.answers);
}

/// The harmonic mean of the two.
double f1Of(const WordAnswer& answer) {
  return 2 * static_cast<double>(answer.correct) / static_cast<double>(answer.answers + answer.returned);
}

Measure<Answers> meanColumn(const std::string& name, int decimals, const OfAnswer& value) {
  return {{name, decimals}, [value](const Answers& answers) { return meanOf(valuesOf(answers, value)); }};
}

const Measure<Answers> queryCount{{"queries", 0},
                                  [](const Answers& answers) { return static_cast<double>(answers.size()); }};

ResultTable meanAveragePrecisions(const std::string& title, const std::string& caption,
                                  const Answers& answers) {
  std::vector<Measure<Answers>> measures{queryCount};
  for (std::size_t m = 0; m < LabelFinders::methods().size(); ++m)
    measures.push_back(meanColumn(LabelFinders::methods()[m].name, 3, averagePrecisionBy(m)));
  return pivot<Answers>({title, caption, "kind", {}, {}}, byKind(answers), measures);
}

ResultTable returnedLabels(const std::string& title, const Answers& answers) {
  return pivot<Answers>(
      {title,
       fmt::format("Labels that search returns, of probability {} or more or by their names: means over "
                   "queries; a query without any has 0.",
                   LabelSearch::defaultMinProbability),
       "kind",
       {},
       {}},
      byKind(answers),
      {queryCount, meanColumn("answers", 1, [](auto& a) { return static_cast<double>(a.answers); }),
       meanColumn("returned", 1, [](auto& a) { return static_cast<double>(a.returned); }),
       meanColumn("precision", 3, precisionOf), meanColumn("recall", 3, recallOf),
       meanColumn("F1", 3, f1Of)});
}

ResultTable weakest(const std::string& title, Answers answers) {
  constexpr std::size_t shown = 15;
  std::ranges::stable_sort(answers, {}, [](const WordAnswer* a) { return a->averagePrecisions.back(); });
  if (answers.size() > shown) answers.resize(shown);
  ResultTable table{title, "Average precision of the queries that search answers worst.", "query", {}, {}};
  table.columns.push_back({"answers", 0});
  for (const auto& [name, explanation] : LabelFinders::methods()) table.columns.push_back({name, 3});
  for (const WordAnswer* answer : answers) {
    ResultTable::Row row{fmt::format("{}: {}", answer->kind, answer->query),
                         {static_cast<double>(answer->answers)}};
    for (const double precision : answer->averagePrecisions) row.values.emplace_back(precision);
    table.rows.push_back(std::move(row));
  }
  return table;
}

/// Depends on the machine, as nothing else here does.
ResultTable searchTimes(const std::string& model, const std::vector<WordAnswer>& answers) {
  std::vector<double> times;
  for (const WordAnswer& answer : answers) times.push_back(answer.milliseconds);
  std::ranges::sort(times);
  return {model + ": time of a search",
          "On one thread of this machine, WordNet being read; all queries.",
          "method",
          {{"median [ms]", 1}, {"at most [ms]", 1}},
          {{LabelFinders::methods().back().name, {times[times.size() / 2], times.back()}}}};
}

/// Half of the 95 % interval of a mean, by its standard error.
double intervalOf(const std::vector<double>& values) {
  const double mean = meanOf(values);
  double squares = 0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  const auto count = static_cast<double>(values.size());
  return values.size() < 2 ? 0 : 1.96 * std::sqrt(squares / (count - 1) / count);
}

}  // namespace

Findings wordsFindings(const std::string& model, const std::vector<WordAnswer>& answers) {
  Findings findings;
  findings.title = "Labels found by words";
  const Answers reported = halfOfAnswers(answers, true);
  const std::size_t search = LabelFinders::methods().size() - 1;
  const Answers& told = reported.empty() ? halfOfAnswers(answers, false) : reported;
  const std::vector<double> own = valuesOf(told, averagePrecisionBy(search));
  findings.summary = fmt::format(
      "{}: labels are found by words with a mean average precision of {:.3f} ± {:.3f} ({} queries), by "
      "matching names with {:.3f}.",
      model, meanOf(own), intervalOf(own), told.size(), meanOf(valuesOf(told, averagePrecisionBy(0))));

  std::string methods = "Mean average precision over all labels; of equal scores, all orders are averaged.";
  for (const auto& [name, explanation] : LabelFinders::methods())
    methods += fmt::format(" {}: {}.", name, explanation);
  for (const bool isOdd : {true, false}) {
    const Answers half = halfOfAnswers(answers, isOdd);
    if (half.empty()) continue;
    const std::string name = fmt::format(
        "{}, {}", model, isOdd ? "odd queries (reported)" : "even queries (weights were chosen on them)");
    findings.sections.emplace_back(meanAveragePrecisions(name, isOdd ? methods : "", half));
    findings.sections.emplace_back(returnedLabels(name + ": labels returned", half));
  }
  // Only even queries: mistakes that are looked at get mended, and odd ones would measure nothing any more.
  findings.sections.emplace_back(
      weakest(model + ", even queries: the weakest", halfOfAnswers(answers, false)));

  findings.sections.emplace_back(searchTimes(model, answers));
  return findings;
}

}  // namespace estancia::experiments
