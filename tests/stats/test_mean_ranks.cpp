// SPDX-License-Identifier: Apache-2.0
#include "estancia/stats/rank_tests.hpp"
#include "support/errors.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace estancia {
namespace {

using test::FailsWith;

using testing::ElementsAre;
using ScoreRow = std::vector<double>;

TEST(Ranks, EqualSciPy) {
  // scipy 1.10.1, rankdata(values)
  EXPECT_THAT(ranks(ScoreRow{3, 1, 4, 1, 5, 9, 2, 6, 5, 3, 5}, Better::smaller),
              ElementsAre(4.5, 1.5, 6, 1.5, 8, 11, 3, 10, 8, 4.5, 8));
  EXPECT_THAT(ranks(ScoreRow{0.5, 0.5, 0.5}, Better::smaller), ElementsAre(2, 2, 2));
  EXPECT_THAT(ranks(ScoreRow{-2, 0, -2, 1e300}, Better::smaller), ElementsAre(1.5, 3, 1.5, 4));
  EXPECT_TRUE(ranks(ScoreRow{}, Better::smaller).empty());
}

TEST(Ranks, RefuseWhatIsNoNumber) {
  EXPECT_THAT(
      [&] {
        ranks(ScoreRow{1, std::numeric_limits<double>::quiet_NaN()}, Better::smaller);
      },
      FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT(
      [&] {
        ranks(ScoreRow{1, std::numeric_limits<double>::infinity()}, Better::smaller);
      },
      FailsWith(ErrorCode::invalidInput));
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
}

TEST(Standings, RefuseTestsThatDoNotFit) {
  EXPECT_THAT([&] { standings({}, Better::smaller); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { standings({{1, 2}, {1}}, Better::smaller); }, FailsWith(ErrorCode::mismatch));
}

}  // namespace
}  // namespace estancia
