// SPDX-License-Identifier: Apache-2.0
#include "estancia/stats/method_comparison.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "estancia/core/fail.hpp"

namespace estancia {
namespace {

void requireUnique(const std::vector<std::string>& names, const char* what) {
  std::set<std::string> known;
  for (const std::string& name : names)
    if (!known.insert(name).second)
      fail(ErrorCode::invalidInput, "two {}s are called \"{}\"; give each a name of its own", what, name);
}

void requireComplete(const MethodScores& scores) {
  if (scores.methods.empty() || scores.tests.empty())
    fail(ErrorCode::invalidInput, "there are {} methods and {} tests; give at least one of each",
         scores.methods.size(), scores.tests.size());
  requireUnique(scores.methods, "method");
  requireUnique(scores.tests, "test");
  if (scores.values.size() != scores.tests.size())
    fail(ErrorCode::mismatch, "there are scores of {} tests, but {} names; give one a test",
         scores.values.size(), scores.tests.size());
  for (std::size_t t = 0; t < scores.tests.size(); ++t) {
    if (scores.values[t].size() != scores.methods.size())
      fail(ErrorCode::mismatch, "test \"{}\" has {} scores for {} methods; give one a method",
           scores.tests[t], scores.values[t].size(), scores.methods.size());
    for (std::size_t m = 0; m < scores.methods.size(); ++m)
      if (!std::isfinite(scores.values[t][m]))
        fail(ErrorCode::invalidInput, "the score of \"{}\" in test \"{}\" is {}; give a finite number",
             scores.methods[m], scores.tests[t], scores.values[t][m]);
  }
}

/// See MethodComparison::groups.
std::vector<std::pair<std::size_t, std::size_t>> groupsOf(const MethodComparison& result) {
  const std::size_t k = result.rows.size();
  if (k < 2) return {};
  if (!result.differ) return {{0, k - 1}};
  const auto rowOf = [&] {
    std::vector<std::size_t> rows(k);
    for (std::size_t r = 0; r < k; ++r) rows[result.rows[r].method] = r;
    return rows;
  }();
  // All tests judge by the difference of mean ranks alone, so each row's equals reach up to some last row.
  std::vector<std::size_t> last(k);
  std::iota(last.begin(), last.end(), std::size_t{0});
  for (const PairTest& pair : result.pairs) {
    if (pair.adjusted <= result.options.alpha) continue;
    const auto [low, high] = std::minmax(rowOf[pair.first], rowOf[pair.second]);
    last[low] = std::max(last[low], high);
  }
  std::vector<std::pair<std::size_t, std::size_t>> groups;
  if (result.options.postHoc == PostHoc::holm) {
    const std::size_t control = rowOf[result.control];
    std::size_t first = control;
    while (first > 0 && last[first - 1] >= control) --first;
    if (last[control] > first) groups.emplace_back(first, last[control]);
    return groups;
  }
  for (std::size_t r = 0; r < k; ++r)
    if (last[r] > r && (groups.empty() || last[r] > groups.back().second)) groups.emplace_back(r, last[r]);
  return groups;
}

}  // namespace

OptionGroup declare(ComparisonOptions& options) {
  OptionGroup group("comparison", "Statistical comparison of methods over several tests.");
  group.add("better", options.better,
            {{{"larger", "accuracies"}, Better::larger}, {{"smaller", "errors and times"}, Better::smaller}},
            "Whether larger or smaller scores are better.");
  group
      .add("post-hoc", options.postHoc,
           {{postHocs()[0], PostHoc::holm},
            {postHocs()[1], PostHoc::shaffer},
            {postHocs()[2], PostHoc::nemenyi}},
           "Post-hoc test.")
      .why("holm compares with a control and is the most powerful; the others compare all pairs");
  group.add("alpha", &options.alpha, "Probability of finding any difference where there is none.")
      .above(0, std::nextafter(1.0, 0.0))
      .why("smaller values find fewer differences, and are more often right");
  group.add("control", &options.control, "Method that the others are compared with.")
      .automatic("the method of the best mean rank");
  return group;
}

MethodComparison compareMethods(MethodScores scores, const ComparisonOptions& options) {
  validate(options);
  requireComplete(scores);
  MethodComparison result;
  const std::size_t k = scores.methods.size();
  const std::vector<double> rank = meanRanks(scores.values, options.better);
  const auto chosen =
      options.control.empty()
          ? scores.methods.begin() + (std::min_element(rank.begin(), rank.end()) - rank.begin())
          : std::find(scores.methods.begin(), scores.methods.end(), options.control);
  if (chosen == scores.methods.end())
    fail(ErrorCode::unknownName, "unknown method \"{}\"; known: {}", options.control,
         fmt::join(scores.methods, ", "));
  result.control = static_cast<std::size_t>(chosen - scores.methods.begin());
  result.friedman = friedmanTest(scores.values);
  result.differ = result.friedman.fP <= options.alpha;
  result.pairs = postHocTests(options.postHoc, rank, scores.tests.size(), result.control);
  if (options.postHoc == PostHoc::nemenyi && k > 1)
    result.criticalDifference = criticalDifference(options.alpha, k, scores.tests.size());

  std::vector<std::optional<double>> p(k);
  for (const PairTest& pair : result.pairs)
    if (pair.first == result.control || pair.second == result.control)
      p[pair.first == result.control ? pair.second : pair.first] = pair.adjusted;
  for (std::size_t m = 0; m < k; ++m)
    result.rows.push_back({m, rank[m], p[m], result.differ && p[m] && *p[m] <= options.alpha,
                           m == result.control
                               ? WinRecord{}
                               : recordAgainst(scores.values, result.control, m, options.better)});
  std::stable_sort(result.rows.begin(), result.rows.end(),
                   [](const auto& a, const auto& b) { return a.meanRank < b.meanRank; });
  if (k == 2) {
    std::vector<double> first, second;
    for (const auto& test : scores.values) {
      first.push_back(test[0]);
      second.push_back(test[1]);
    }
    result.wilcoxon = wilcoxonTest(first, second);
  }
  result.scores = std::move(scores);
  result.options = options;
  result.groups = groupsOf(result);
  return result;
}

}  // namespace estancia
