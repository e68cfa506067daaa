// SPDX-License-Identifier: Apache-2.0
#include "estancia/stats/clustering_agreement.hpp"
#include "estancia/stats/proportion.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "support/errors.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using testing::ElementsAre;

struct Stored {
  const char* name;
  std::vector<int> truth, clusters;
  double homogeneity, completeness, vMeasure, adjustedRandIndex, purity;
};

/// Made with scikit-learn 1.2.1:
///   from sklearn import metrics as m
///   m.homogeneity_completeness_v_measure(t, p); m.adjusted_rand_score(t, p)
///   c = m.cluster.contingency_matrix(t, p); c.max(0).sum() / c.sum()      # purity
std::vector<Stored> storedCases() {
  std::vector<int> t,
      p;  // xs = [(1103515245*i + 12345) % 65536 for i in range(500)]; t = x % 4; p = x//7 % 6
  for (std::int64_t i = 0; i < 500; ++i) {
    const auto x = static_cast<int>((1103515245 * i + 12345) % 65536);
    t.push_back(x % 4);
    p.push_back(x / 7 % 6);
  }
  return {{"ten items",
           {0, 0, 0, 1, 1, 2, 2, 2, 2, 2},
           {5, 5, 1, 1, 1, 1, 7, 7, 7, 5},
           0.410633921782165,
           0.38829136267187,
           0.399150228815332,
           0.136690647482014,
           0.7},
          {"rooms that are visited again",
           {0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 2, 2, 2, 0, 0},
           {0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3, 0, 0},
           0.715084780757673,
           0.536758777471573,
           0.613220446252801,
           0.430885529157667,
           0.823529411764706},
          {"worse than chance", {0, 1, 0, 1}, {0, 0, 1, 1}, 0, 0, 0, -0.5, 0.5},
          {"unrelated", t, p, 0.00820401081523542, 0.00634814663893141, 0.0071577377920112,
           -0.00187640452323776, 0.296}};
}

TEST(Agreement, EqualsScikitLearn) {
  for (const Stored& stored : storedCases()) {
    const Agreement found = measureAgreement(stored.truth, stored.clusters);
    EXPECT_NEAR(found.homogeneity, stored.homogeneity, 1e-12) << stored.name;
    EXPECT_NEAR(found.completeness, stored.completeness, 1e-12) << stored.name;
    EXPECT_NEAR(found.vMeasure, stored.vMeasure, 1e-12) << stored.name;
    EXPECT_NEAR(found.adjustedRandIndex, stored.adjustedRandIndex, 1e-12) << stored.name;
    EXPECT_NEAR(found.purity, stored.purity, 1e-12) << stored.name;
  }
}

TEST(Agreement, OfASingleClusterIsCompleteButNotHomogeneous) {
  const std::vector<int> truth{1, 1, 2, 3}, one(4, 9);
  const Agreement found = measureAgreement(truth, one);
  EXPECT_DOUBLE_EQ(found.homogeneity, 0);
  EXPECT_DOUBLE_EQ(found.completeness, 1);
  EXPECT_DOUBLE_EQ(found.vMeasure, 0);
  EXPECT_DOUBLE_EQ(found.adjustedRandIndex, 0);
  EXPECT_DOUBLE_EQ(found.purity, 0.5);
}

TEST(Agreement, NeedsItemsAndEqualLengths) {
  const std::vector<int> none, two{1, 2};
  EXPECT_THAT([&] { measureAgreement(none, none); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { measureAgreement(two, none); }, FailsWith(ErrorCode::mismatch));
}

TEST(Agreement, OfNamedClassesLeavesOutItemsWithoutAName) {
  const std::vector<std::string> names{"hall", "", "hall", "bath", "bath", "", "bath"};
  const std::vector<int> clusters{0, 1, 0, 1, 1, 0, 0};
  const NamedAgreement named = measureNamedAgreement(names, clusters);
  const Agreement expected = measureAgreement(std::vector{0, 0, 1, 1, 1}, std::vector{0, 0, 1, 1, 0});
  EXPECT_EQ(named.items, 5U);
  ASSERT_TRUE(named.agreement);
  EXPECT_EQ(named.agreement->vMeasure, expected.vMeasure);
  EXPECT_EQ(named.agreement->purity, 0.8);
  EXPECT_FALSE(measureNamedAgreement(std::vector<std::string>{"", ""}, std::vector{0, 1}).agreement);
  EXPECT_FALSE(measureNamedAgreement({}, {}).agreement);
  EXPECT_THAT([&] { measureNamedAgreement(names, std::vector{0}); }, FailsWith(ErrorCode::mismatch));
}

TEST(KeptNumbers, AreThoseOfTheLargestOverlap) {
  // Group 0 is what was 2, group 1 what was 0; group 2 is new.
  EXPECT_THAT(keptNumbers(3, {{{0, 2}, 50}, {{0, 0}, 3}, {{1, 0}, 20}}), ElementsAre(2, 0, 1));
}

TEST(KeptNumbers, AreGivenOnce) {
  // A split: the larger part keeps the number.
  EXPECT_THAT(keptNumbers(2, {{{0, 0}, 30}, {{1, 0}, 70}}), ElementsAre(1, 0));
  // Merged: the number of what was more of it.
  EXPECT_THAT(keptNumbers(1, {{{0, 1}, 70}, {{0, 0}, 30}}), ElementsAre(0)) << "1 would leave a gap";
}

TEST(KeptNumbers, OfGroupsWithoutEarlierOnesAreInOrder) {
  EXPECT_THAT(keptNumbers(3, {}), ElementsAre(0, 1, 2));
  EXPECT_THAT(keptNumbers(0, {}), ElementsAre());
  EXPECT_THAT(keptNumbers(2, {{{7, 0}, 5}, {{0, 9}, 5}}), ElementsAre(0, 1)) << "none of these";
}

// scipy.stats.binomtest(k, n).proportion_ci(method="wilson")
TEST(WilsonInterval, IsSciPys) {
  const auto expectInterval = [](std::size_t hits, std::size_t trials, double low, double high) {
    const auto interval = wilsonInterval(hits, trials);
    EXPECT_NEAR(interval.first, low, 1e-9) << hits;
    EXPECT_NEAR(interval.second, high, 1e-9) << hits;
  };
  expectInterval(0, 10, 0, 0.277532799863);
  expectInterval(10, 10, 0.722467200137, 1);
  expectInterval(1, 1, 0.206549314377, 1);
  expectInterval(397, 516, 0.731124278461, 0.803654153084);
  expectInterval(4, 7, 0.250458364528, 0.841780144749);
}

TEST(WilsonInterval, RefusesWhatIsNoShare) {
  EXPECT_THAT([] { wilsonInterval(std::size_t{0}, std::size_t{0}); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([] { wilsonInterval(std::size_t{3}, std::size_t{2}); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([] { wilsonInterval(1.5, 2.0); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([] { wilsonInterval(0.5, 0.0); }, FailsWith(ErrorCode::invalidInput));
}

}  // namespace
}  // namespace estancia
