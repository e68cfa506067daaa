// Several methods compared over several tests: from their scores to what differs.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "estancia/stats/friedman.hpp"
#include "estancia/stats/mean_ranks.hpp"
#include "estancia/stats/post_hoc.hpp"
#include "estancia/stats/wilcoxon.hpp"

namespace estancia {

/// What each method reached in each test: accuracies of descriptor/classifier pairs over train→test pairs.
struct MethodScores {
  std::vector<std::string> methods, tests;  ///< names, each once
  std::vector<std::vector<double>> values;  ///< [test][method]
};

struct ComparisonOptions {
  Better better = Better::larger;  ///< smaller for errors and times
  PostHoc postHoc = PostHoc::holm;
  double alpha = 0.05;  ///< the chance, inside (0, 1), of seeing any difference where there is none
  std::string control;  ///< the method that the others are compared with; "": the one of the best mean rank
};

/// Friedman's test and a post-hoc test with what tables and images show of them (thesis Table 3.2; Demšar,
/// JMLR 7 (2006)).
struct MethodComparison {
  /// One method beside the control.
  struct Row {
    std::size_t method = 0;
    double meanRank = 0;
    std::optional<double> p;  ///< adjusted, of the method against the control; none for the control itself
    bool rejected = false;    ///< that it is equivalent to the control
    Record control;           ///< how the control did against it: wins are tests where the control is better
  };
  MethodScores scores;
  ComparisonOptions options;
  FriedmanTest friedman;
  bool differ = false;  ///< whether F_F of Iman and Davenport rejects that all are equivalent
  std::size_t control = 0;
  std::vector<Row> rows;        ///< one a method, the best mean rank first
  std::vector<PairTest> pairs;  ///< of postHocTests()
  /// Of the rows, first and last of those next to each other that are not found to differ, the longest such
  /// stretches of two or more: with Holm's test the one around the control; all rows unless `differ`.
  std::vector<std::pair<std::size_t, std::size_t>> groups;
  std::optional<double> criticalDifference;  ///< Nemenyi's
  std::optional<WilcoxonTest> wilcoxon;      ///< of two methods, where it is the better test (Demšar 3.1.3)
};

/// Compares. Nothing is rejected unless Friedman's test (by F_F, the less conservative) rejects first. Equal
/// mean ranks stay in the order of the methods. Throws Error when a score is not finite, saying whose and
/// where, the table has holes, no method, no test or a name twice, alpha is not inside (0, 1), the control is
/// unknown (lists the known ones), and as postHocTests() does.
MethodComparison compareMethods(MethodScores scores, const ComparisonOptions& options = {});

}  // namespace estancia
