// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "estancia/stats/clustering_agreement.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using test::FailsWith;

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

/// Random labelings of random length, the same ones every time.
class Cases {
 public:
  std::size_t length() { return 1 + random_() % 60; }
  std::vector<int> labels(std::size_t count) {
    std::vector<int> result(count);
    for (int& label : result) label = static_cast<int>(random_() % 6);
    return result;
  }

 private:
  std::mt19937 random_{7};
};

TEST(Agreement, DoesNotDependOnNamesAndStaysInBounds) {
  Cases cases;
  for (int i = 0; i < 200; ++i) {
    const std::size_t count = cases.length();
    const auto truth = cases.labels(count), clusters = cases.labels(count);
    std::vector<int> renamed;
    for (const int name : clusters) renamed.push_back((name * 5 + 3) % 7 - 3);
    const Agreement a = measureAgreement(truth, clusters), b = measureAgreement(truth, renamed);
    EXPECT_NEAR(a.vMeasure, b.vMeasure, 1e-12);
    EXPECT_NEAR(a.adjustedRandIndex, b.adjustedRandIndex, 1e-12);
    EXPECT_EQ(a.purity, b.purity);
    for (const double value : {a.homogeneity, a.completeness, a.vMeasure, a.purity}) {
      EXPECT_GE(value, 0);
      EXPECT_LE(value, 1);
    }
    EXPECT_LE(a.adjustedRandIndex, 1 + 1e-12);
    // The other direction swaps homogeneity and completeness.
    const Agreement swapped = measureAgreement(clusters, truth);
    EXPECT_NEAR(a.homogeneity, swapped.completeness, 1e-12);
    EXPECT_NEAR(a.adjustedRandIndex, swapped.adjustedRandIndex, 1e-12);
  }
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

}  // namespace
}  // namespace estancia
