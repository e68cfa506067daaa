// SPDX-License-Identifier: Apache-2.0
#include "estancia/stats/method_comparison.hpp"
#include "estancia/stats/rank_tests.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "stats/scipy_random.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using ScoreRow = std::vector<double>;
using ScoreTable = std::vector<std::vector<double>>;
using test::FailsWith;
using testing::ElementsAre;

TEST(Friedman, PerfectAgreementIsNoBetterThanItsChance) {
  const FriedmanTest found = friedmanTest(ScoreTable(6, {3, 2, 1}));
  EXPECT_DOUBLE_EQ(found.chiSquared, 12);
  EXPECT_TRUE(std::isinf(found.f));
  EXPECT_NEAR(found.fP, std::pow(6, -5), 1e-15) << "five tests rank as the first did";
  EXPECT_NEAR(friedmanTest(ScoreTable(3, {1, 2})).fP, 0.25, 1e-15) << "three tosses of a coin";
  EXPECT_NEAR(found.p, std::exp(-6), 1e-12) << "χ² of 2 degrees";
}

TEST(Friedman, SaysWhenThereIsNothingToTestAndRefusesWhatIsNoTable) {
  for (const ScoreTable& table :
       {ScoreTable{{1}, {2}}, ScoreTable{{1, 2, 3}}, ScoreTable{{5, 5, 5}, {7, 7, 7}}}) {
    const FriedmanTest found = friedmanTest(table);
    EXPECT_NE(found.undefined, "");
    EXPECT_EQ(found.p, 1);
    EXPECT_EQ(found.fP, 1);
  }
  EXPECT_THAT([&] { friedmanTest({}); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { friedmanTest({{1, 2}, {1}}); }, FailsWith(ErrorCode::mismatch));
  const ScoreTable nan{{1, NAN}};
  EXPECT_THAT([&] { friedmanTest(nan); }, FailsWith(ErrorCode::invalidInput));
}

double relative(double found, double expected) {
  return std::abs(found - expected) / expected;
}

TEST(PostHoc, ReproducesTheThesisTableAndThePaperOfGarciaAndHerrera) {
  // ScoreTable 3.2: 12 descriptor/classifier pairs in 25 tests, against ESF/RFs. All eleven p-values come out
  // in all five digits that are printed: with 25 tests two decimals determine a mean rank.
  const ScoreRow ranks{2.70, 4.22, 4.32, 6.24, 6.54, 6.56, 6.64, 7.30, 7.46, 7.68, 7.94, 10.40};
  const ScoreRow printed{2.2433e-01, 2.2433e-01, 1.5541e-03, 7.6841e-04, 7.6841e-04, 6.7068e-04,
                         4.5236e-05, 2.4383e-05, 9.3896e-06, 2.7732e-06, 4.7705e-13};
  const auto found = postHocTests(PostHoc::holm, ranks, 25);
  ASSERT_EQ(found.size(), printed.size());
  for (std::size_t i = 0; i < printed.size(); ++i) {
    EXPECT_EQ(found[i].first, 0U);
    EXPECT_EQ(found[i].second, i + 1);
    EXPECT_LT(relative(found[i].adjusted, printed[i]), 1.5e-5) << "rank " << ranks[i + 1];
  }
  // JMLR 9 (2008): C4.5, 1NN, naive Bayes, Kernel and CN2 on 30 data sets, by their printed mean ranks; of
  // five methods 10, 6, 4, 3, 2, 1 or 0 hypotheses can be true together.
  const ScoreRow ofPaper{2.100, 3.250, 2.200, 4.333, 3.117};
  const auto pairs = postHocTests(PostHoc::shaffer, ofPaper, 30);
  ASSERT_EQ(pairs.size(), 10U);
  const auto of = [&](std::size_t a, std::size_t b) {
    return *std::find_if(pairs.begin(), pairs.end(), [&](auto& p) { return p.first == a && p.second == b; });
  };
  EXPECT_LT(relative(of(0, 3).p, 4.487e-8), 0.01);
  EXPECT_LT(relative(of(2, 3).p, 1.736e-7), 0.01);
  EXPECT_DOUBLE_EQ(of(0, 3).adjusted, 10 * of(0, 3).p);
  EXPECT_DOUBLE_EQ(of(2, 3).adjusted, 6 * of(2, 3).p);
  EXPECT_DOUBLE_EQ(of(3, 4).adjusted, 6 * of(3, 4).p);
  EXPECT_DOUBLE_EQ(of(0, 1).adjusted, 6 * of(0, 1).p);
}

TEST(PostHoc, ComparesInThePromisedOrder) {
  const ScoreRow ranks{2, 1, 3};
  const auto control = postHocTests(PostHoc::holm, ranks, 10, 1);
  ASSERT_EQ(control.size(), 2U);
  EXPECT_EQ(control[0].first, 1U);
  EXPECT_EQ(control[0].second, 0U);
  EXPECT_EQ(control[1].second, 2U);
  EXPECT_GT(control[0].z, 0) << "the control is better";
  const auto all = postHocTests(PostHoc::nemenyi, ranks, 10);
  ASSERT_EQ(all.size(), 3U);
  EXPECT_LT(all[0].z, 0) << "the second is better";
  EXPECT_EQ(all[2].first, 1U);
  EXPECT_EQ(all[2].second, 2U);
}

TEST(PostHoc, RefusesWhatMakesNoSense) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto holm = [](const ScoreRow& ranks, std::size_t tests, std::size_t control) {
    return [=] { postHocTests(PostHoc::holm, ranks, tests, control); };
  };
  for (const auto& call :
       {holm({1, 2}, 0, 0), holm({1, 2}, 5, 2), holm({1, 2.1}, 5, 0), holm({1, nan}, 5, 0)})
    EXPECT_THAT(call, FailsWith(ErrorCode::invalidInput));
  for (const double p : {1.5, nan})
    EXPECT_THAT([&] { holmAdjusted(ScoreRow{p}); }, FailsWith(ErrorCode::invalidInput));
  for (const std::size_t methods : {std::size_t{3}, std::numeric_limits<std::size_t>::max()})
    EXPECT_THAT([&] { shafferAdjusted(ScoreRow{0.5, 0.5}, methods); }, FailsWith(ErrorCode::invalidInput));
  for (const double alpha : {0.0, 1.0})
    EXPECT_THAT([&] { criticalDifference(alpha, 4, 5); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([] { criticalDifference(0.05, 4, 0); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([] { criticalDifference(0.05, 1, 5); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([] { studentizedRangeTail(1, 1); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { studentizedRangeTail(nan, 3); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { studentizedRangeQuantile(nan, 3); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([] { postHocTests(PostHoc::shaffer, ScoreRow(501, 251.0), 5); },
              FailsWith(ErrorCode::tooLarge));
}

TEST(StudentizedRange, HasItsQuantilesAndLimits) {
  for (const std::size_t groups : {2U, 12U, 1000000000U}) {
    EXPECT_EQ(studentizedRangeTail(0, groups), 1);
    EXPECT_EQ(studentizedRangeTail(-1, groups), 1);
    for (const double alpha : {0.999, 0.05, 1e-30})
      EXPECT_NEAR(studentizedRangeTail(studentizedRangeQuantile(alpha, groups), groups) / alpha, 1, 1e-8);
  }
  EXPECT_EQ(studentizedRangeTail(std::numeric_limits<double>::infinity(), 3), 0);
}

TEST(Ranks, EqualSciPyAndRefuseWhatIsNoNumber) {
  // scipy 1.10.1, rankdata(values)
  EXPECT_THAT(ranks(ScoreRow{3, 1, 4, 1, 5, 9, 2, 6, 5, 3, 5}, Better::smaller),
              ElementsAre(4.5, 1.5, 6, 1.5, 8, 11, 3, 10, 8, 4.5, 8));
  EXPECT_THAT(ranks(ScoreRow{0.5, 0.5, 0.5}, Better::smaller), ElementsAre(2, 2, 2));
  EXPECT_THAT(ranks(ScoreRow{-2, 0, -2, 1e300}, Better::smaller), ElementsAre(1.5, 3, 1.5, 4));
  EXPECT_TRUE(ranks(ScoreRow{}, Better::smaller).empty());
  for (const ScoreRow& bad : {ScoreRow{1, NAN}, ScoreRow{1, INFINITY}})
    EXPECT_THAT([&] { ranks(bad, Better::smaller); }, FailsWith(ErrorCode::invalidInput));
}

TEST(Standings, CountWinsTiesAndLossesOfEveryPair) {
  const auto found = standings({{1, 2, 3}, {1, 1, 3}, {4, 2, 2}}, Better::smaller);
  ASSERT_EQ(found.size(), 3U);
  EXPECT_DOUBLE_EQ(found[0].meanRank, (1 + 1.5 + 3) / 3);
  EXPECT_DOUBLE_EQ(found[1].meanRank, (2 + 1.5 + 1.5) / 3);
  EXPECT_DOUBLE_EQ(found[2].meanRank, (3 + 3 + 1.5) / 3);
  const auto counts = [](const MethodStanding& s) { return std::vector{s.wins, s.ties, s.losses}; };
  EXPECT_THAT(counts(found[0]), ElementsAre(3, 1, 2));
  EXPECT_THAT(counts(found[1]), ElementsAre(3, 2, 1));
  EXPECT_THAT(counts(found[2]), ElementsAre(1, 1, 4));
  EXPECT_THAT([&] { standings({}, Better::smaller); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { standings({{1, 2}, {1}}, Better::smaller); }, FailsWith(ErrorCode::mismatch));
}

TEST(Wilcoxon, LeavesOutEqualTestsAndRefusesWhatCannotBeCompared) {
  const WilcoxonTest found = wilcoxonTest(ScoreRow{1, 2, 3, 4, 5}, ScoreRow{1, 0, 0, 0, 0});
  EXPECT_EQ(found.different, 4U);
  EXPECT_FALSE(found.exact);
  EXPECT_DOUBLE_EQ(found.better, 10);
  EXPECT_EQ(wilcoxonTest(ScoreRow{2, 2}, ScoreRow{2, 2}).p, 1) << "nowhere different";
  EXPECT_THAT([&] { wilcoxonTest(ScoreRow{1, 2}, ScoreRow{1}); }, FailsWith(ErrorCode::mismatch));
  EXPECT_THAT([&] { wilcoxonTest(ScoreRow{}, ScoreRow{}); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([] { wilcoxonTest(ScoreRow{1, NAN}, ScoreRow{1, 2}); }, FailsWith(ErrorCode::invalidInput));
}

/// `steps[m]` apart on average, so that method 0 is the best where they fall.
MethodScores sample(std::uint64_t seed, std::size_t tests, const std::vector<double>& means, double noise) {
  test::Random random(seed);
  MethodScores scores;
  for (std::size_t m = 0; m < means.size(); ++m) scores.methods.push_back(std::string(1, 'a' + char(m)));
  for (std::size_t t = 0; t < tests; ++t) {
    scores.tests.push_back("test " + std::to_string(t));
    scores.values.emplace_back();
    for (const double mean : means) scores.values.back().push_back(mean + noise * random.uniform());
  }
  return scores;
}

TEST(MethodComparison, RanksTestsAndCountsAgainstTheBest) {
  // c is best, then a, then b, in every test; d equals a everywhere.
  MethodScores scores{{"a", "b", "c", "d"}, {}, {}};
  for (int t = 0; t < 20; ++t) {
    scores.tests.push_back(std::to_string(t));
    scores.values.push_back({0.8, 0.5, t == 0 ? 0.8 : 0.9, 0.8});
  }
  const MethodComparison found = compareMethods(scores);
  EXPECT_EQ(found.control, 2U);
  EXPECT_TRUE(found.differ);
  std::vector<std::size_t> order;
  for (const auto& row : found.rows) order.push_back(row.method);
  EXPECT_THAT(order, ElementsAre(2, 0, 3, 1)) << "a before d: equal ranks stay in order";
  EXPECT_FALSE(found.rows[0].p);
  EXPECT_FALSE(found.rows[0].rejected);
  EXPECT_EQ(found.rows[1].control, (WinRecord{19, 1, 0}));
  EXPECT_EQ(found.rows[3].control, (WinRecord{20, 0, 0}));
  EXPECT_TRUE(found.rows[3].rejected);
  EXPECT_DOUBLE_EQ(found.rows[3].meanRank, 4);
  EXPECT_EQ(found.pairs.size(), 3U);
  EXPECT_FALSE(found.criticalDifference);
  EXPECT_FALSE(found.wilcoxon);

  ComparisonOptions smaller;
  smaller.better = Better::smaller;
  const MethodComparison turned = compareMethods(scores, smaller);
  EXPECT_EQ(turned.control, 1U) << "the smallest is the best now";
  EXPECT_DOUBLE_EQ(turned.rows[0].meanRank, 1);
}

TEST(MethodComparison, GroupsWhatIsNotFoundToDiffer) {
  const MethodScores scores = sample(3, 30, {4, 3.9, 2, 1.95, 0}, 1.5);
  ComparisonOptions options;
  for (const PostHoc postHoc : {PostHoc::shaffer, PostHoc::nemenyi}) {
    options.postHoc = postHoc;
    const MethodComparison found = compareMethods(scores, options);
    EXPECT_EQ(found.pairs.size(), 10U);
    EXPECT_EQ(found.criticalDifference.has_value(), postHoc == PostHoc::nemenyi);
    EXPECT_THAT(found.groups, ElementsAre(testing::Pair(0, 1), testing::Pair(2, 3)));
    EXPECT_FALSE(found.rows[1].rejected);
    EXPECT_TRUE(found.rows[2].rejected);
  }
  options.postHoc = PostHoc::holm;
  EXPECT_THAT(compareMethods(scores, options).groups, ElementsAre(testing::Pair(0, 1)));
  options.control = "d";
  const MethodComparison against = compareMethods(scores, options);
  EXPECT_EQ(against.control, 3U);
  EXPECT_THAT(against.groups, ElementsAre(testing::Pair(2, 3)));
  EXPECT_EQ(against.rows[4].control, (WinRecord{30, 0, 0})) << "d against e";
  options.control = "e";
  EXPECT_TRUE(compareMethods(scores, options).groups.empty()) << "differs from all";
}

TEST(MethodComparison, RefusesScoresThatDoNotFit) {
  const MethodScores sound{{"a", "b"}, {"t", "u"}, {{1, 2}, {3, 4}}};
  const auto refused = [](const MethodScores& scores, const ComparisonOptions& options = {}) {
    return [scores, options] { compareMethods(scores, options); };
  };
  for (const MethodScores& bad : {MethodScores{}, MethodScores{{"a", "b"}, {"t", "u"}, {{1, 2}, {NAN, 4}}},
                                  MethodScores{{"a", "b"}, {"t", "u"}, {{1, 2}, {INFINITY, 4}}},
                                  MethodScores{{"a", "a"}, {"t", "u"}, sound.values},
                                  MethodScores{{"a", "b"}, {"t", "t"}, sound.values}})
    EXPECT_THAT(refused(bad), FailsWith(ErrorCode::invalidInput));
  for (const MethodScores& bad :
       {MethodScores{{"a", "b"}, {"t", "u"}, {{1, 2}, {3}}}, MethodScores{{"a", "b"}, {"t", "u"}, {{1, 2}}}})
    EXPECT_THAT(refused(bad), FailsWith(ErrorCode::mismatch));
  EXPECT_THAT(refused(sound, {.control = "c"}), FailsWith(ErrorCode::unknownName));
  for (const double alpha : {0.0, 1.0, static_cast<double>(NAN)})
    EXPECT_THAT(refused(sound, {.alpha = alpha, .control = {}}), FailsWith(ErrorCode::invalidOption));
}

}  // namespace
}  // namespace estancia
