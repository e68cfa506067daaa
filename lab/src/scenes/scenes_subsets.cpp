// SPDX-License-Identifier: Apache-2.0
#include "scenes/scenes_subsets.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "estancia/findings/comparison_findings.hpp"
#include "estancia/stats/rank_tests.hpp"
#include "findings/pivot.hpp"
#include "scenes/scenes_statistics.hpp"

namespace estancia::experiments {
namespace {

using Curve = ScenesResults::Curve;
constexpr std::size_t thesisCount = 75;  // labels, of 793

/// The answers with the labels of number k, as if they were all the cells.
ScenesResults pointOf(const ScenesResults& results, const Curve& curve, std::size_t k) {
  ScenesResults point;
  point.pairs = results.pairs;
  point.descriptors = {{results.curveDescriptor, true, 1}};
  point.classifiers = {results.curveClassifier};
  point.cells = curve.answers[k];
  return point;
}

double percent(const ScenesResults& results, const Curve& curve, std::size_t k) {
  return 100 * meanAccuracies(pointOf(results, curve, k), {0}).front();
}

std::vector<double> blockShares(const ScenesResults& results, const Curve& curve, std::size_t k) {
  const ScenesResults point = pointOf(results, curve, k);
  std::vector<double> shares;
  for (const auto& block : scoresOfCells(point, blocksOf(point)).values) shares.push_back(block[0]);
  return shares;
}

}  // namespace

LineChart subsetCurve(const ScenesResults& results) {
  LineChart chart{fmt::format("{}: {} in fewer labels, {} (Fig. 3.11)", results.name, results.curveDescriptor,
                              results.curveClassifier),
                  "Labels are chosen on the training images alone (the thesis chose them on all images). " +
                      subsetAnswer(results),
                  "labels",
                  "accuracy [%]",
                  false,
                  {results.counts.begin(), results.counts.end()},
                  {},
                  true};
  for (const Curve& curve : results.curves) {
    auto& line = chart.lines.emplace_back(LineChart::Line{curve.rule, {}});
    for (std::size_t k = 0; k < results.counts.size(); ++k) line.y.push_back(percent(results, curve, k));
  }
  return chart;
}

ResultTable subsetTable(const ScenesResults& results) {
  std::vector<std::string> rules, counts;
  for (const Curve& curve : results.curves) rules.push_back(curve.rule);
  for (const std::size_t count : results.counts) counts.push_back(std::to_string(count));
  return pivot({fmt::format("{}: accuracy of {} in fewer labels", results.name, results.curveDescriptor),
                fmt::format("In percent, by {}; labels chosen by each of the rules. Intervals are in "
                            "{}-subsets.csv.",
                            results.curveClassifier, results.name),
                "labels",
                columnsOf(rules, 1, ResultTable::Best::largest),
                {}},
               counts, [&](std::size_t count, std::size_t rule) {
                 return percent(results, results.curves[rule], count);
               });
}

std::string subsetAnswer(const ScenesResults& results) {
  const auto found = std::find(results.counts.begin(), results.counts.end(), thesisCount);
  if (found == results.counts.end() || results.labels <= thesisCount ||
      results.counts.back() != results.labels)
    return "";
  const auto few = static_cast<std::size_t>(found - results.counts.begin());
  const std::size_t all = results.counts.size() - 1;
  std::string verdict, differences;
  for (const Curve& curve : results.curves) {
    const double difference = percent(results, curve, few) - percent(results, curve, all);
    const double p = wilcoxonTest(blockShares(results, curve, few), blockShares(results, curve, all)).p;
    if (verdict.empty() || curve.rule == "mean")  // the thesis' rule decides
      verdict = difference <= 0 ? "does not hold here"
                : p < 0.05      ? "holds here"
                                : "holds here by chance at most";
    differences += fmt::format("{}{:+.1f} points by {} (Wilcoxon {})", differences.empty() ? "" : ", ",
                               difference, curve.rule, pText(p));
  }
  return fmt::format("That {} labels beat all of them {}: against all {}, {}.", thesisCount, verdict,
                     results.counts.back(), differences);
}

}  // namespace estancia::experiments
