// SPDX-License-Identifier: Apache-2.0
#include "estancia/findings/comparison_findings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estancia/findings/result_table.hpp"
#include "support/golden_findings.hpp"

namespace estancia {
namespace {

using testing::ElementsAre;

/// a is always a little better than b; c is far behind but for the first `cAhead` tests, where it is best.
MethodScores sampleScores(int tests, int cAhead = 0) {
  MethodScores scores{{"c", "a", "b"}, {}, {}};
  for (int t = 0; t < tests; ++t) {
    scores.tests.push_back(std::to_string(t));
    scores.values.push_back({t < cAhead ? 0.95 : 0.1, 0.9, 0.8});
  }
  return scores;
}

Findings compare(const MethodScores& scores, ComparisonOptions options = {}) {
  return comparisonFindings(compareMethods(scores, options));
}

TEST(ComparisonFindings, AreWholeFiles) {
  test::expectGolden("comparison-different", compare(sampleScores(20)));
  test::expectGolden("comparison-equal", compare(sampleScores(9, 3)));
  ComparisonOptions options;
  options.control = "b";
  test::expectGolden("comparison-control", compare(sampleScores(20), options));
  test::expectGolden("comparison-few", compare(sampleScores(4, 2)));
  test::expectGolden("comparison-two", compare({{"a", "b"}, {"t", "u"}, {{1, 0}, {2, 0}}}));
  options = {};
  options.postHoc = PostHoc::nemenyi;
  test::expectGolden("comparison-nemenyi", compare(sampleScores(20), options));
}

TEST(ComparisonFindings, SayThatEqualScoresDoNotDiffer) {
  test::expectGolden("comparison-same", compare({{"a", "b"}, {"t", "u"}, {{1, 1}, {1, 1}}}));
  test::expectGolden("comparison-one", compare({{"a"}, {"t"}, {{1}}}));
}

TEST(ComparisonFindings, NoPIsZero) {
  const Findings findings = compare(sampleScores(1000));
  for (const auto& [name, value] : findings.facts)
    EXPECT_THAT(value, testing::Not(testing::ContainsRegex("p = (0$|0[^.]|<)"))) << name;
  EXPECT_EQ(pText(0), "p < 1e-300");
  EXPECT_EQ(pText(1e-299), "p = 1.0e-299");
  EXPECT_EQ(pText(0.0123), "p = 0.012");
  EXPECT_EQ(cellText(comparisonTable(compareMethods(sampleScores(20))).columns[0], 0.0), "< 1e-300");
}

}  // namespace
}  // namespace estancia
