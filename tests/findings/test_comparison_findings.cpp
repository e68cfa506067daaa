// SPDX-License-Identifier: Apache-2.0
#include "estancia/findings/comparison_findings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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

TEST(ComparisonFindings, AreTheTableOfTheThesis) {
  const ResultTable table = comparisonTable(compareMethods(sampleScores(20)));
  std::vector<std::string> columns;
  for (const auto& column : table.columns) columns.push_back(column.name);
  EXPECT_THAT(columns, ElementsAre("p-value", "rejected", "rank", "win", "tie", "loss"));
  ASSERT_EQ(table.rows.size(), 3U);
  EXPECT_EQ(table.rows[0].name, "a");
  EXPECT_FALSE(table.rows[0].values[0] || table.rows[0].values[3]);
  EXPECT_EQ(table.rows[2].name, "c");
  EXPECT_THAT(table.rows[2].values, ElementsAre(testing::Optional(testing::Lt(1e-8)), 1, 3, 20, 0, 0));
  EXPECT_EQ(cellText(table.columns[1], table.rows[2].values[1]), "yes");
  EXPECT_EQ(table.columns[0].form, ResultTable::Form::scientific);
}

TEST(ComparisonFindings, DrawTheControlOrAllPairs) {
  const RankDiagram control = comparisonDiagram(compareMethods(sampleScores(9, 3)));
  EXPECT_EQ(control.control, 0U);
  EXPECT_EQ(control.methods[0].name, "a");
  ComparisonOptions options;
  options.postHoc = PostHoc::nemenyi;
  const MethodComparison nemenyi = compareMethods(sampleScores(20), options);
  const RankDiagram pairs = comparisonDiagram(nemenyi);
  EXPECT_FALSE(pairs.control);
  EXPECT_TRUE(pairs.criticalDifference);
  const Findings findings = comparisonFindings(nemenyi);
  ASSERT_EQ(findings.sections.size(), 3U);
  const auto& matrix = std::get<HeatTable>(findings.sections[2]);
  EXPECT_THAT(matrix.names, ElementsAre("a", "b", "c"));
  EXPECT_EQ(matrix.at(0, 2), matrix.at(2, 0));
  EXPECT_LT(matrix.at(0, 2), matrix.at(0, 1));
  EXPECT_EQ(comparisonFindings(compareMethods(sampleScores(20))).sections.size(), 2U);
}

TEST(ComparisonFindings, WarnOfWhatIsNotToBeTrusted) {
  EXPECT_EQ(compare(sampleScores(20)).notes.size(), 1U) << "few methods";
  EXPECT_EQ(compare(sampleScores(4, 2)).notes.size(), 2U) << "few tests, and nothing found";
  EXPECT_EQ(test::notesNaming(compare({{"a", "b"}, {"t", "u"}, {{1, 0}, {2, 0}}}), "p = 0.500"), 1U);
}

}  // namespace
}  // namespace estancia
