// SPDX-License-Identifier: Apache-2.0
#include "estancia/findings/comparison_findings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace estancia {
namespace {

const std::string& nameOf(const MethodComparison& comparison, std::size_t method) {
  return comparison.scores.methods[method];
}

const std::string& controlName(const MethodComparison& comparison) {
  return nameOf(comparison, comparison.control);
}

std::string postHocName(PostHoc postHoc) {
  return postHoc == PostHoc::holm ? "Holm" : postHoc == PostHoc::shaffer ? "Shaffer" : "Nemenyi";
}

/// "a, b and 3 more".
std::string someOf(const std::vector<std::string>& names) {
  constexpr std::size_t maxNames = 4;
  std::string text;
  for (std::size_t i = 0; i < std::min(maxNames, names.size()); ++i) text += (i > 0 ? ", " : "") + names[i];
  return names.size() > maxNames ? fmt::format("{} and {} more", text, names.size() - maxNames) : text;
}

std::string wilcoxonText(const WilcoxonTest& test) {
  return fmt::format("{} ({})", pText(test.p),
                     test.exact            ? "exact"
                     : test.different == 0 ? "nowhere different"
                                           : "normal approximation");
}

std::string summaryOf(const MethodComparison& comparison) {
  const std::size_t methods = comparison.rows.size(), tests = comparison.scores.tests.size();
  const FriedmanTest& friedman = comparison.friedman;
  if (!friedman.undefined.empty())
    return fmt::format("No significant difference: {} (p = 1).", friedman.undefined);
  const auto& best = comparison.rows.front();
  if (!comparison.differ)
    return fmt::format(
        "No difference is found between {} methods in {} tests (Iman–Davenport, {}); {} has the best mean "
        "rank, {:.2f}.",
        methods, tests, pText(friedman.fP), nameOf(comparison, best.method), best.meanRank);
  std::vector<std::string> equals, others;
  for (const auto& row : comparison.rows)
    if (row.method != comparison.control)
      (row.rejected ? others : equals).push_back(nameOf(comparison, row.method));
  const std::string control = controlName(comparison);
  std::string text = fmt::format("{} methods differ over {} tests (Iman–Davenport, {}). ", methods, tests,
                                 pText(friedman.fP));
  const bool isBest = best.method == comparison.control;
  text += isBest ? fmt::format("{} is the best (mean rank {:.2f})", control, best.meanRank)
                 : fmt::format("{} has the best mean rank, {:.2f}. {}", nameOf(comparison, best.method),
                               best.meanRank, control);
  if (others.empty()) return text + (isBest ? ", but" : "") + " is not found to differ from any other.";
  if (isBest) text += " and";
  if (equals.empty()) return text + " differs from all others.";
  return text +
         fmt::format(" is not found to differ from {}; it differs from {}.", someOf(equals), someOf(others));
}

/// The critical-difference diagram.
RankDiagram comparisonDiagram(const MethodComparison& comparison) {
  RankDiagram diagram;
  diagram.title = "Mean ranks";
  const std::size_t tests = comparison.scores.tests.size();
  diagram.caption = comparison.options.postHoc == PostHoc::holm
                        ? fmt::format(
                              "Mean ranks over {} tests, best at the left. The bar joins {} with the "
                              "methods that are not found to differ from it (Holm, α = {}).",
                              tests, controlName(comparison), comparison.options.alpha)
                        : fmt::format(
                              "Mean ranks over {} tests, best at the left. Bars join methods that are "
                              "not found to differ ({}, all pairs, α = {}).",
                              tests, postHocName(comparison.options.postHoc), comparison.options.alpha);
  if (!comparison.differ) diagram.caption += " Friedman's test finds no difference, so a bar joins all.";
  for (std::size_t r = 0; r < comparison.rows.size(); ++r) {
    diagram.methods.push_back({nameOf(comparison, comparison.rows[r].method), comparison.rows[r].meanRank});
    if (comparison.options.postHoc == PostHoc::holm && comparison.rows[r].method == comparison.control)
      diagram.control = r;
  }
  diagram.groups = comparison.groups;
  diagram.criticalDifference = comparison.criticalDifference;
  return diagram;
}

/// Adjusted p-values of all pairs, in the order of the rows.
HeatTable pairMatrix(const MethodComparison& comparison) {
  HeatTable matrix;
  matrix.title = "Adjusted p-values of all pairs";
  matrix.caption = fmt::format("{}; two methods differ where p ≤ {}.",
                               postHocName(comparison.options.postHoc), comparison.options.alpha);
  matrix.decimals = 3;
  const std::size_t k = comparison.rows.size();
  std::vector<std::size_t> rowOf(k);
  for (std::size_t r = 0; r < k; ++r) {
    rowOf[comparison.rows[r].method] = r;
    matrix.names.push_back(nameOf(comparison, comparison.rows[r].method));
  }
  matrix.values.assign(k * k, std::numeric_limits<double>::quiet_NaN());
  for (const PairTest& pair : comparison.pairs) {
    const std::size_t a = rowOf[pair.first], b = rowOf[pair.second];
    matrix.values[a * k + b] = matrix.values[b * k + a] = pair.adjusted;
  }
  return matrix;
}

}  // namespace

std::string pText(double p) {
  if (p < 1e-300) return "p < 1e-300";  // below what a number can hold, or nearly
  return p < 0.001 ? fmt::format("p = {:.1e}", p) : fmt::format("p = {:.3f}", p);
}

ResultTable comparisonTable(const MethodComparison& comparison) {
  const bool allPairs = comparison.options.postHoc != PostHoc::holm;
  const std::string control = controlName(comparison);
  ResultTable table{
      fmt::format("Methods against {} (as thesis Table 3.2)", control),
      fmt::format("p: adjusted by {}{}. Rejected: that the method is equivalent to {}, at α = {}. "
                  "Rank: the mean over {} tests, 1 is best. Win, tie, loss: tests where {} is "
                  "better, as good, worse than the method.",
                  postHocName(comparison.options.postHoc), allPairs ? " for all pairs" : "", control,
                  comparison.options.alpha, comparison.scores.tests.size(), control),
      "method",
      {{"p-value", 4, ResultTable::Best::none, ResultTable::Form::scientific},
       {"rejected", 0, ResultTable::Best::none, ResultTable::Form::yesNo},
       {"rank", 2, ResultTable::Best::smallest},
       {"win", 0},
       {"tie", 0},
       {"loss", 0}},
      {}};
  for (const auto& row : comparison.rows) {
    ResultTable::Row cells{nameOf(comparison, row.method),
                           {row.p, row.rejected ? 1 : 0, row.meanRank, {}, {}, {}}};
    if (row.method != comparison.control) {
      cells.values[3] = static_cast<double>(row.control.wins);
      cells.values[4] = static_cast<double>(row.control.ties);
      cells.values[5] = static_cast<double>(row.control.losses);
    }
    table.rows.push_back(std::move(cells));
  }
  return table;
}

Findings comparisonFindings(const MethodComparison& comparison) {
  const FriedmanTest& friedman = comparison.friedman;
  const std::size_t methods = comparison.rows.size(), tests = comparison.scores.tests.size();
  Findings findings;
  findings.title = fmt::format("{} methods compared over {} tests", methods, tests);
  findings.summary = summaryOf(comparison);
  findings.facts = {
      {"Friedman",
       fmt::format("χ²({}) = {:.3f}, {}", friedman.degrees, friedman.chiSquared, pText(friedman.p))},
      {"Iman–Davenport", fmt::format("F({}, {}) = {:.3f}, {}", friedman.fDegrees, friedman.fOtherDegrees,
                                     friedman.f, pText(friedman.fP))},
      {"Post-hoc test",
       postHocName(comparison.options.postHoc) + (comparison.options.postHoc == PostHoc::holm
                                                      ? ", against " + controlName(comparison)
                                                      : ", all pairs")},
      {"α", fmt::format("{}", comparison.options.alpha)},
      {"Better scores are", comparison.options.better == Better::larger ? "larger" : "smaller"}};
  if (comparison.criticalDifference)
    findings.facts.emplace_back("Critical difference of mean ranks",
                                fmt::format("{:.3f}", *comparison.criticalDifference));
  if (comparison.wilcoxon) findings.facts.emplace_back("Wilcoxon", wilcoxonText(*comparison.wilcoxon));
  findings.sections.emplace_back(comparisonDiagram(comparison));
  findings.sections.emplace_back(comparisonTable(comparison));
  if (comparison.options.postHoc != PostHoc::holm && methods > 1 && methods <= 40)
    findings.sections.emplace_back(pairMatrix(comparison));
  if (comparison.wilcoxon && friedman.undefined.empty())
    findings.notes.push_back("Of two methods only, Wilcoxon's signed-rank test is the better one: " +
                             wilcoxonText(*comparison.wilcoxon) + ".");
  else if (friedman.undefined.empty() && (tests <= 10 || methods <= 5))
    findings.notes.emplace_back(
        "With at most 10 tests or 5 methods the p-values of Friedman's test are rough (Demšar 2006).");
  if (!comparison.differ && methods > 1)
    findings.notes.emplace_back(
        "Friedman's test does not reject that all methods are equivalent, so no pair is called different, "
        "whatever its own p-value.");
  return findings;
}

}  // namespace estancia
