// SPDX-License-Identifier: Apache-2.0
#include "estancia/stats/rank_tests.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "estancia/stats/studentized_range.hpp"
#include "stats/scipy_random.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using test::FailsWith;

using ScoreRow = std::vector<double>;

double relative(double found, double expected) {
  return std::abs(found - expected) / expected;
}

TEST(PostHoc, ReproducesTheThesisTable) {
  // ScoreTable 3.2: 12 descriptor/classifier pairs in 25 tests, against ESF/RFs. All eleven p-values come out
  // in all five digits that are printed: with 25 tests two decimals say all of a mean rank.
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
}

TEST(PostHoc, ReproducesThePaperOfDemsar) {
  // JMLR 7 (2006), 3.2.2: four variants of C4.5 on 14 data sets, by their printed mean ranks; C4.5 is the
  // first.
  const ScoreRow ranks{3.143, 2.000, 2.893, 1.964};
  const auto found = postHocTests(PostHoc::holm, ranks, 14);
  EXPECT_NEAR(-found[2].z, 2.416, 0.001);
  EXPECT_NEAR(-found[0].z, 2.342, 0.001);
  EXPECT_NEAR(-found[1].z, 0.512, 0.001);
  EXPECT_NEAR(found[2].p, 0.016, 0.0005);
  EXPECT_NEAR(found[0].p, 0.019, 0.0005);
  EXPECT_NEAR(found[1].p, 0.607, 0.002);
  EXPECT_NEAR(criticalDifference(0.05, 4, 14), 1.25, 0.005);
  // Its ScoreTable 5a: q_0.05 and q_0.10 of Nemenyi's test for 2 … 10 methods.
  const ScoreRow five{1.960, 2.343, 2.569, 2.728, 2.850, 2.949, 3.031, 3.102, 3.164};
  const ScoreRow ten{1.645, 2.052, 2.291, 2.459, 2.589, 2.693, 2.780, 2.855, 2.920};
  for (std::size_t k = 2; k <= 10; ++k) {
    const double error = std::sqrt(static_cast<double>(k * (k + 1)) / 6);
    EXPECT_NEAR(criticalDifference(0.05, k, 1) / error, five[k - 2], 0.0015);
    EXPECT_NEAR(criticalDifference(0.10, k, 1) / error, ten[k - 2], 0.0015);
  }
}

TEST(PostHoc, ReproducesThePaperOfGarciaAndHerrera) {
  // JMLR 9 (2008): C4.5, 1NN, naive Bayes, Kernel and CN2 on 30 data sets, by their printed mean ranks; of
  // five methods 10, 6, 4, 3, 2, 1 or 0 hypotheses can be true together.
  const ScoreRow ranks{2.100, 3.250, 2.200, 4.333, 3.117};
  const auto found = postHocTests(PostHoc::shaffer, ranks, 30);
  ASSERT_EQ(found.size(), 10U);
  const auto of = [&](std::size_t a, std::size_t b) {
    return *std::find_if(found.begin(), found.end(), [&](auto& p) { return p.first == a && p.second == b; });
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
  const std::vector<std::function<void()>> calls{
      [] {
        postHocTests(PostHoc::holm, ScoreRow{1, 2}, 0);
      },
      [] {
        postHocTests(PostHoc::holm, ScoreRow{1, 2}, 5, 2);
      },
      [] {
        postHocTests(PostHoc::holm, ScoreRow{1, 2.1}, 5);
      },
      [=] {
        postHocTests(PostHoc::nemenyi, ScoreRow{1, nan}, 5);
      },
      [] {
        holmAdjusted(ScoreRow{0.5, 1.5});
      },
      [=] { holmAdjusted(ScoreRow{nan}); },
      [] {
        shafferAdjusted(ScoreRow{0.5, 0.5}, 3);
      },
      [] { shafferAdjusted(ScoreRow{}, std::numeric_limits<std::size_t>::max()); },
      [] { criticalDifference(0.05, 4, 0); },
      [] { criticalDifference(0.05, 1, 5); },
      [] { criticalDifference(0, 4, 5); },
      [] { criticalDifference(1, 4, 5); },
      [] { studentizedRangeTail(1, 1); },
      [=] { studentizedRangeTail(nan, 3); },
      [=] { studentizedRangeQuantile(nan, 3); }};
  for (std::size_t i = 0; i < calls.size(); ++i)
    EXPECT_THAT(calls[i], FailsWith(ErrorCode::invalidInput)) << i;
  EXPECT_THAT([] { postHocTests(PostHoc::shaffer, ScoreRow(501, 251.0), 5); },
              FailsWith(ErrorCode::tooLarge));
  EXPECT_THAT([] { getPostHoc("tukey"); }, FailsWith(ErrorCode::unknownName));
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

}  // namespace
}  // namespace estancia
