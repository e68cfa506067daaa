// Method comparison: which of several methods differ significantly over several tests.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "estancia/core/options.hpp"
#include "estancia/stats/rank_tests.hpp"

namespace estancia {

/// The score of each method in each test: accuracies of descriptor/classifier pairs over train→test pairs.
struct MethodScores {
  /// Names, each once.
  std::vector<std::string> methods, tests;
  /// [test][method]
  std::vector<std::vector<double>> values;
};

struct ComparisonOptions {
  Better better = Better::larger;
  PostHoc postHoc = PostHoc::holm;
  double alpha = 0.05;
  std::string control;
};
OptionGroup declare(ComparisonOptions& options);

/// Friedman's test and a post-hoc test (thesis Table 3.2; Demšar, JMLR 7 (2006)).
struct MethodComparison {
  /// One method beside the control.
  struct Row {
    std::size_t method = 0;
    double meanRank = 0;
    /// Adjusted, of the method against the control; none for the control itself.
    std::optional<double> p;
    /// Whether the hypothesis that it is equivalent to the control is rejected.
    bool rejected = false;
    /// The control against this method: wins are tests where the control is better.
    WinRecord control;
  };
  MethodScores scores;
  ComparisonOptions options;
  FriedmanTest friedman;
  /// Whether F_F of Iman and Davenport rejects that all methods are equivalent.
  bool differ = false;
  std::size_t control = 0;
  /// One a method, the best mean rank first.
  std::vector<Row> rows;
  /// Result of postHocTests().
  std::vector<PairTest> pairs;
  /// First and last row of each maximal range of two or more rows that do not differ significantly: with
  /// Holm's test the one around the control; all rows unless `differ`.
  std::vector<std::pair<std::size_t, std::size_t>> groups;
  /// Nemenyi's.
  std::optional<double> criticalDifference;
  /// Test of two methods, where it is the better test (Demšar 3.1.3).
  std::optional<WilcoxonTest> wilcoxon;
};

/// Compares. Nothing is rejected unless Friedman's test (by F_F, the less conservative) rejects first. Equal
/// mean ranks stay in the order of the methods. Throws Error (invalidInput, mismatch) when a score is not
/// finite or the table not complete, empty, or with a name twice; on the options; and as postHocTests().
MethodComparison compareMethods(MethodScores scores, const ComparisonOptions& options = {});

}  // namespace estancia
