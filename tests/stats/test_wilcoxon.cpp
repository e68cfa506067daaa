// SPDX-License-Identifier: Apache-2.0
#include "estancia/stats/rank_tests.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "stats/scipy_random.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using test::FailsWith;

using ScoreRow = std::vector<double>;

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
