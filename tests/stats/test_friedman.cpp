// SPDX-License-Identifier: Apache-2.0
#include "estancia/stats/rank_tests.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "stats/scipy_random.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using test::FailsWith;

using ScoreTable = std::vector<std::vector<double>>;

ScoreTable randomTable(std::uint64_t seed, std::size_t tests, std::size_t methods, double steps) {
  test::Random random(seed);
  ScoreTable table(tests, std::vector<double>(methods));
  for (auto& test : table)
    for (double& value : test) value = std::floor(random.uniform() * steps) / steps;
  return table;
}

TEST(Friedman, ReproducesThePaperOfDemsar) {
  // JMLR 7 (2006), ScoreTable 6, the printed ranks: χ²_F = 9.28 without the correction for ties, which is
  // 1 − 78 / (14 · 60) for three pairs and one four of equal values.
  const ScoreTable ranks{{4, 3, 2, 1},     {1, 2, 3, 4}, {4, 1, 2, 3},     {4, 1, 3, 2}, {4, 2, 3, 1},
                         {1, 2.5, 4, 2.5}, {3, 2, 4, 1}, {2.5, 2.5, 4, 1}, {4, 3, 2, 1}, {2.5, 2.5, 2.5, 2.5},
                         {4, 2.5, 1, 2.5}, {3, 2, 4, 1}, {4, 1, 2, 3},     {3, 1, 4, 2}};
  const double uncorrected = friedmanTest(ranks).chiSquared * (1 - 78.0 / 840);
  EXPECT_NEAR(uncorrected, 9.28, 0.005);
  EXPECT_NEAR(13 * uncorrected / (14 * 3 - uncorrected), 3.69, 0.005);
}

TEST(Friedman, PerfectAgreementIsNoBetterThanItsChance) {
  const FriedmanTest found = friedmanTest(ScoreTable(6, {3, 2, 1}));
  EXPECT_DOUBLE_EQ(found.chiSquared, 12);
  EXPECT_TRUE(std::isinf(found.f));
  EXPECT_NEAR(found.fP, std::pow(6, -5), 1e-15) << "five tests rank as the first did";
  EXPECT_NEAR(friedmanTest(ScoreTable(3, {1, 2})).fP, 0.25, 1e-15) << "three tosses of a coin";
  EXPECT_NEAR(found.p, std::exp(-6), 1e-12) << "χ² of 2 degrees";
}

TEST(Friedman, SaysWhenThereIsNothingToTest) {
  for (const ScoreTable& table :
       {ScoreTable{{1}, {2}}, ScoreTable{{1, 2, 3}}, ScoreTable{{5, 5, 5}, {7, 7, 7}}}) {
    const FriedmanTest found = friedmanTest(table);
    EXPECT_NE(found.undefined, "");
    EXPECT_EQ(found.p, 1);
    EXPECT_EQ(found.fP, 1);
  }
}

TEST(Friedman, RefusesWhatIsNoTable) {
  EXPECT_THAT([&] { friedmanTest({}); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { friedmanTest({{1, 2}, {1}}); }, FailsWith(ErrorCode::mismatch));
  EXPECT_THAT(
      [&] {
        friedmanTest({{1, std::numeric_limits<double>::quiet_NaN()}});
      },
      FailsWith(ErrorCode::invalidInput));
}

}  // namespace
}  // namespace estancia
