// SPDX-License-Identifier: Apache-2.0
#include "estancia/stats/linkage.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "support/errors.hpp"

namespace estancia {
namespace {

using test::FailsWith;

const std::vector<Comparison> everyComparison{
    Comparison::meanSquare,    Comparison::rootMeanSquare, Comparison::l1,
    Comparison::euclidean,     Comparison::chebyshev,      Comparison::chiSquared,
    Comparison::bhattacharyya, Comparison::cosine,         Comparison::kullbackLeibler,
    Comparison::jensenShannon};

DescriptorMatrix distributions(std::size_t items, std::size_t labels, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  DescriptorMatrix rows(labels);
  std::vector<float> row(labels);
  for (std::size_t i = 0; i < items; ++i) {
    float sum = 0;
    for (float& v : row) sum += v = std::exp(2 * normal(random));
    for (float& v : row) v /= sum;
    rows.append(row);
  }
  return rows;
}

std::vector<double> valuesOf(const CondensedDistances& distances) {
  return {distances.values().begin(), distances.values().end()};
}

TEST(PairwiseDistances, AreThoseOfEachPairInPdistsOrder) {
  for (const std::size_t items : {2U, 3U, 16U, 17U, 65U, 130U})
    for (const std::size_t labels : {1U, 5U, 205U}) {
      const DescriptorMatrix rows = distributions(items, labels);
      for (const Comparison comparison : everyComparison) {
        const CondensedDistances distances = pairwiseDistances(rows, comparison);
        ASSERT_EQ(distances.values().size(), items * (items - 1) / 2);
        std::size_t place = 0;
        for (std::size_t i = 0; i < items; ++i)
          for (std::size_t j = i + 1; j < items; ++j) {
            const double expected = compare(comparison, rows.row(i), rows.row(j)), found = distances(j, i);
            ASSERT_NEAR(found, expected, 1e-6 + 3e-5 * expected)
                << items << "×" << labels << ", comparison " << static_cast<int>(comparison) << ", " << i
                << " " << j;
            ASSERT_EQ(found, distances(i, j));
            ASSERT_EQ(found, distances.values()[place++]);
          }
      }
    }
}

TEST(PairwiseDistances, DoNotDependOnTheNumberOfThreads) {
  const DescriptorMatrix rows = distributions(300, 41);
  for (const Comparison comparison : everyComparison) {
    const auto expected = valuesOf(pairwiseDistances(rows, comparison, 1));
    for (const int threads : {2, 3, 8})
      EXPECT_EQ(valuesOf(pairwiseDistances(rows, comparison, threads)), expected);
  }
}

TEST(PairwiseDistances, OfTheSameAreExactlyZeroAndNoneIsNegative) {
  const DescriptorMatrix some = distributions(20, 77);
  DescriptorMatrix rows(77);
  for (std::size_t i = 0; i < 60; ++i) {
    std::vector<float> row(some.row(i % 20).begin(), some.row(i % 20).end());
    if (i >= 40) row[i] *= 1 + 1e-6F;  // all but the same
    rows.append(row);
  }
  for (const Comparison comparison : everyComparison) {
    const CondensedDistances distances = pairwiseDistances(rows, comparison);
    for (std::size_t i = 0; i < 20; ++i) {
      EXPECT_EQ(distances(i, i + 20), 0) << static_cast<int>(comparison);
      EXPECT_NEAR(distances(i, i + 40), 0, 1e-4) << static_cast<int>(comparison);
    }
    for (const double d : distances.values()) EXPECT_GE(d, 0) << static_cast<int>(comparison);
  }
}

TEST(PairwiseDistances, ZeroVectorsAreAlikeAmongThemselvesOnly) {
  DescriptorMatrix rows(3);
  for (const auto& row : {std::vector<float>{0, 0, 0}, {0, 0, 0}, {0.5F, 0.2F, 0.3F}}) rows.append(row);
  const CondensedDistances distances = pairwiseDistances(rows, Comparison::cosine);
  EXPECT_EQ(distances(0, 1), 0);
  EXPECT_EQ(distances(0, 2), 1);
  for (const Comparison comparison : everyComparison)
    for (const double d : valuesOf(pairwiseDistances(rows, comparison)))
      EXPECT_TRUE(std::isfinite(d) && d >= 0);
}

TEST(PairwiseDistances, RefuseWhatIsNoNumberAndSayWhere) {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    DescriptorMatrix rows = distributions(4, 3);
    rows.append(std::vector<float>{0.5F, bad, 0});
    EXPECT_THAT([&] { pairwiseDistances(rows, Comparison::l1); }, FailsWith(ErrorCode::invalidInput));
  }
}

TEST(CondensedDistances, SaysItsMemoryAndRefusesWhatNoMachineHas) {
  EXPECT_EQ(CondensedDistances::bytes(0), 0U);
  EXPECT_EQ(CondensedDistances::bytes(1), 0U);
  EXPECT_EQ(CondensedDistances::bytes(50000), 50000ULL * 49999 / 2 * 8);
  EXPECT_EQ(CondensedDistances::bytes(std::numeric_limits<std::size_t>::max()),
            std::numeric_limits<std::uint64_t>::max());
  EXPECT_THAT([] { CondensedDistances{std::numeric_limits<std::size_t>::max()}; },
              FailsWith(ErrorCode::tooLarge));
  EXPECT_THAT([] { CondensedDistances{std::size_t{1} << 40}; }, FailsWith(ErrorCode::tooLarge));
}

}  // namespace
}  // namespace estancia
