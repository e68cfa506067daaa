// SPDX-License-Identifier: Apache-2.0
#include "scenes/scenes_rankings.hpp"

#include <fmt/format.h>

#include <string>
#include <utility>
#include <variant>

#include "estancia/findings/comparison_findings.hpp"
#include "estancia/stats/method_comparison.hpp"
#include "findings/thesis.hpp"
#include "scenes/scenes_statistics.hpp"

namespace estancia::experiments {
namespace {

constexpr std::size_t maxDrawn = 40;   // methods of a diagram
constexpr std::size_t maxListed = 25;  // rows of a table among others, when not all are drawn

std::string describe(const SceneBlocks& blocks) {
  if (!blocks.runs)
    return fmt::format(
        "The {} tests are the pairs of training and test, as in the thesis. They share sequences, so that "
        "p-values are smaller than they should be.",
        blocks.right.size());
  return fmt::format(
      "The {} tests are the runs of the test images: each shows one room, in images taken one after another. "
      "So it is asked whether these classifiers, as they were trained, differ in other rooms of the kind; "
      "not "
      "whether they would after learning from other images.",
      blocks.right.size());
}

}  // namespace

void addRankings(const ScenesResults& results, const std::string& prefix, Findings& findings) {
  const SceneBlocks blocks = blocksOf(results);
  if (blocks.right.size() < 2) {
    findings.notes.push_back(results.name +
                             ": all test images are one run in one room, so there is nothing "
                             "to rank over");
    return;
  }
  findings.facts.emplace_back(results.name + ", tests of the ranks", describe(blocks));
  const auto add = [&](const std::string& what, const std::string& file, const std::string& of,
                       MethodScores scores) {
    if (scores.methods.size() < 2) return;
    const MethodComparison comparison = compareMethods(std::move(scores));
    Findings found = comparisonFindings(comparison);
    const std::string title = fmt::format("{}: {}", results.name, what);
    findings.facts.emplace_back(title, found.summary);
    for (auto& section : found.sections) {
      if (auto* table = std::get_if<ResultTable>(&section)) {
        table->title = fmt::format("{}, against the best (Table 3.2)", title);
        table->caption = fmt::format("{} {}{}", describe(blocks), of, table->caption);
        if (const std::size_t all = table->rows.size(); all > maxDrawn) {
          table->rows.resize(maxListed);
          table->caption +=
              fmt::format(" The best {} of {}; all are in {}-{}.csv.", maxListed, all, prefix, file);
        }
      }
      if (auto* diagram = std::get_if<RankDiagram>(&section)) {
        diagram->title = title + ", mean ranks";
        diagram->caption = found.summary + " " + diagram->caption;
        if (diagram->methods.size() > maxDrawn) continue;
      }
      findings.sections.push_back(section);
    }
    found.title = title + ", which differ";
    found.file = fmt::format("{}-{}", prefix, file);
    findings.apart.push_back(std::move(found));
  };
  add("all cells", "statistics", "", scoresOfCells(results, blocks));
  add("descriptors", "descriptors", "A descriptor's score is its mean over the classifiers. ",
      scoresOfDescriptors(results, blocks));
  add("classifiers", "classifiers", "A classifier's score is its mean over the descriptors. ",
      scoresOfClassifiers(results, blocks));
  if (!results.thesisTables) return;
  using Best = ResultTable::Best;
  findings.sections.emplace_back(readThesisTable(thesisScenesCsv, 2)
                                     .resultTable({"Table 3.2 of the thesis: another data set",
                                                   "ViDRILO, 25 pairs of sequences; Friedman's test with "
                                                   "Holm's correction against the best combination. "
                                                   "Win, tie, loss: pairs in which the best one did better, "
                                                   "as well, worse. To be compared in its course "
                                                   "only.",
                                                   "classifier, descriptor",
                                                   {{"p-value", 4, Best::none, ResultTable::Form::scientific},
                                                    {"rejected", 0, Best::none, ResultTable::Form::yesNo},
                                                    {"rank", 2},
                                                    {"win", 0},
                                                    {"tie", 0},
                                                    {"loss", 0}},
                                                   {}}));
}

}  // namespace estancia::experiments
