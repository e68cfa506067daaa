// SPDX-License-Identifier: Apache-2.0
#include "estancia/stats/rank_tests.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "stats/scipy_random.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using test::FailsWith;

using ScoreRow = std::vector<double>;

TEST(Wilcoxon, ExactPIsTheShareOfSignsThatAreAsOdd) {
  // All 2^n ways to give the ranks a sign, n = 8.
  for (const double last : {-1.0, 1.0}) {
    const ScoreRow differences{last, 2, -3, 4, 5, 6, 7, 8};
    const WilcoxonTest found = wilcoxonTest(differences, ScoreRow(8, 0.0));
    const double observed = std::min(found.better, found.worse);
    int asOdd = 0;
    for (int signs = 0; signs < 256; ++signs) {
      int sum = 0;
      for (int rank = 1; rank <= 8; ++rank) sum += (signs >> (rank - 1) & 1) * rank;
      asOdd += std::min(sum, 36 - sum) <= observed;
    }
    EXPECT_TRUE(found.exact);
    EXPECT_DOUBLE_EQ(found.p, asOdd / 256.0);
    EXPECT_DOUBLE_EQ(found.better + found.worse, 36);
  }
}

TEST(Wilcoxon, LeavesOutEqualTestsAndThenApproximates) {
  const WilcoxonTest found = wilcoxonTest(ScoreRow{1, 2, 3, 4, 5}, ScoreRow{1, 0, 0, 0, 0});
  EXPECT_EQ(found.different, 4U);
  EXPECT_FALSE(found.exact);
  EXPECT_DOUBLE_EQ(found.better, 10);
  EXPECT_EQ(wilcoxonTest(ScoreRow{2, 2}, ScoreRow{2, 2}).p, 1) << "nowhere different";
}

TEST(Wilcoxon, RefusesWhatCannotBeCompared) {
  EXPECT_THAT([&] { wilcoxonTest(ScoreRow{1, 2}, ScoreRow{1}); }, FailsWith(ErrorCode::mismatch));
  EXPECT_THAT([&] { wilcoxonTest(ScoreRow{}, ScoreRow{}); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([] { wilcoxonTest(ScoreRow{1, NAN}, ScoreRow{1, 2}); }, FailsWith(ErrorCode::invalidInput));
}

}  // namespace
}  // namespace estancia
