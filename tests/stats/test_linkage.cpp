// SPDX-License-Identifier: Apache-2.0
#include "estancia/stats/clustering_agreement.hpp"
#include "estancia/stats/linkage.hpp"
#include "estancia/stats/proportion.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "support/errors.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using testing::ElementsAre;

DescriptorMatrix points(std::size_t n, std::size_t labels, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  DescriptorMatrix rows(labels);
  std::vector<float> row(labels);
  for (std::size_t i = 0; i < n; ++i) {
    for (float& v : row) v = normal(random) + static_cast<float>(i % 3);
    rows.append(row);
  }
  return rows;
}

CondensedDistances euclidean(std::size_t n, unsigned seed) {
  return pairwiseDistances(points(n, 3, seed), Comparison::euclidean);
}

TEST(Linkage, KnowsFewItems) {
  for (const Choice& named : linkages()) {
    SCOPED_TRACE(named.name);
    for (const std::size_t n : {0U, 1U}) {
      const Dendrogram dendrogram = link(CondensedDistances(n), getLinkage(named.name));
      EXPECT_TRUE(dendrogram.merges().empty());
      EXPECT_EQ(dendrogram.cutAt(1), std::vector<int>(n, 0));
      EXPECT_EQ(dendrogram.cutInto(n), std::vector<int>(n, 0));
    }
    CondensedDistances two(2);
    two.values()[0] = 0.25;
    const Dendrogram dendrogram = link(std::move(two), getLinkage(named.name));
    EXPECT_EQ(dendrogram.cutAt(0.2), (std::vector<int>{0, 1}));
    EXPECT_EQ(dendrogram.cutAt(0.25), (std::vector<int>{0, 0})) << "merging stops above the distance";
  }
}

TEST(Linkage, RefusesWhatIsNoDistance) {
  for (const Choice& named : linkages())
    for (const double bad : {std::nan(""), -0.5, 1e300, std::numeric_limits<double>::infinity()}) {
      CondensedDistances distances = euclidean(6, 1);
      distances.after(2)[1] = bad;
      EXPECT_THAT([&] { link(std::move(distances), getLinkage(named.name)); },
                  FailsWith(ErrorCode::invalidInput))
          << named.name;
    }
}

/// Leaves that stand for several items merge as those items would.
TEST(Linkage, WeighsLeavesByTheirSizes) {
  const DescriptorMatrix leaves = points(40, 3, 9);
  DescriptorMatrix items(3);
  std::vector<std::size_t> sizes;
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    sizes.push_back(1 + i * i % 5);
    for (std::size_t copy = 0; copy < sizes.back(); ++copy) items.append(leaves.row(i));
  }
  for (const Linkage linkage : {Linkage::single, Linkage::complete, Linkage::average, Linkage::ward}) {
    const Dendrogram all = link(pairwiseDistances(items, Comparison::euclidean), linkage);
    const Dendrogram few = link(pairwiseDistances(leaves, Comparison::euclidean), linkage, sizes);
    const std::size_t copies = items.size() - leaves.size();
    ASSERT_EQ(few.merges().size(), 39U);
    for (std::size_t k = 0; k < 39; ++k)
      EXPECT_NEAR(few.merges()[k].height, all.merges()[copies + k].height, 1e-5) << static_cast<int>(linkage);
    EXPECT_EQ(few.merges().back().size, items.size());
  }
}

TEST(Linkage, RefusesSizesThatAreNone) {
  for (const std::vector<std::size_t>& sizes : {std::vector<std::size_t>{1, 2}, {1, 2, 0}, {1, 1, 1, 1}})
    EXPECT_THAT([&] { link(euclidean(3, 1), Linkage::average, sizes); }, FailsWith(ErrorCode::invalidInput));
}

TEST(Linkage, IsChosenByName) {
  std::set<Linkage> known;
  for (const Choice& named : linkages()) known.insert(getLinkage(named.name));
  EXPECT_EQ(known.size(), linkages().size());
  EXPECT_EQ(getLinkage("ward"), Linkage::ward);
  EXPECT_THAT([] { getLinkage("centroid"); }, FailsWith(ErrorCode::unknownName));
}

TEST(ComparisonFor, IsTheDistancesOwnButForWardAndRefusesWhatDoesNotFit) {
  EXPECT_EQ(comparisonFor(getDistance("clr-cosine"), Linkage::average), Comparison::cosine);
  EXPECT_EQ(comparisonFor(getDistance("clr-cosine"), Linkage::ward), Comparison::euclidean);
  EXPECT_EQ(comparisonFor(getDistance("hellinger"), Linkage::ward), Comparison::euclidean);
  EXPECT_EQ(comparisonFor(getDistance("ks"), Linkage::average), Comparison::chebyshev);
  for (const char* name : {"ks", "l1", "chi2", "kullback-leibler", "bhattacharyya"})
    EXPECT_THAT([&] { comparisonFor(getDistance(name), Linkage::ward); },
                FailsWith(ErrorCode::invalidOption));
  for (const char* name : {"ks-sigma", "weighted", "weighted-root"})
    EXPECT_THAT([&] { comparisonFor(getDistance(name), Linkage::average); },
                FailsWith(ErrorCode::invalidOption));
}

TEST(Dendrogram, IsCutByDistanceAndByNumberAndRefusesMergesThatDoNotFollow) {
  //  0 and 2 at 0.1, 1 and 3 at 0.3, all at 0.7
  const Dendrogram dendrogram(4, {{0, 2, 0.1, 2}, {1, 3, 0.3, 2}, {4, 5, 0.7, 4}});
  EXPECT_EQ(dendrogram.cutAt(-1), (std::vector<int>{0, 1, 2, 3}));
  EXPECT_EQ(dendrogram.cutAt(0.1), (std::vector<int>{0, 1, 0, 2}));
  EXPECT_EQ(dendrogram.cutAt(0.69), (std::vector<int>{0, 1, 0, 1}));
  EXPECT_EQ(dendrogram.cutAt(INFINITY), (std::vector<int>{0, 0, 0, 0}));
  EXPECT_EQ(dendrogram.cutInto(3), (std::vector<int>{0, 1, 0, 2}));
  EXPECT_EQ(dendrogram.cutInto(1), (std::vector<int>{0, 0, 0, 0}));
  for (const std::size_t clusters : {0U, 5U})
    EXPECT_THAT([&] { dendrogram.cutInto(clusters); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { dendrogram.cutAt(std::nan("")); }, FailsWith(ErrorCode::invalidInput));
  using Merges = std::vector<Dendrogram::Merge>;
  for (const Merges& merges :
       {Merges{}, Merges{{0, 1, 0.1, 2}}, Merges{{0, 1, 0.1, 2}, {0, 2, 0.2, 2}},
        Merges{{0, 1, 0.2, 2}, {2, 3, 0.1, 3}}, Merges{{0, 1, 0.1, 2}, {2, 4, 0.2, 3}},
        Merges{{1, 1, 0.1, 2}, {2, 3, 0.2, 3}}, Merges{{0, 1, std::nan(""), 2}, {2, 3, 0.2, 3}}})
    EXPECT_THAT([&] { Dendrogram(3, merges); }, FailsWith(ErrorCode::invalidInput));
}

TEST(ClusteringMemory, IsRefusedWhenThereIsLessNamingTheStreamingMode) {
  EXPECT_GT(clusteringMemory(50000, 205), CondensedDistances::bytes(50000));
  EXPECT_LT(clusteringMemory(50000, 205), 12ULL << 30);
  requireClusteringMemory(50000, 205, 12ULL << 30);
  for (const std::size_t images :
       {std::size_t{50000}, std::size_t{1} << 40, std::numeric_limits<std::size_t>::max()})
    EXPECT_THAT([&] { requireClusteringMemory(images, 205, 8ULL << 30); },
                FailsWith(ErrorCode::tooLarge, std::to_string(images), "8.0 GiB", "--stream"));
}

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

struct Stored {
  const char* name;
  std::vector<int> truth, clusters;
  std::vector<double> measures;  ///< homogeneity, completeness, V-measure, adjusted Rand index, purity
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
           {0.410633921782165, 0.38829136267187, 0.399150228815332, 0.136690647482014, 0.7}},
          {"rooms that are visited again",
           {0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 2, 2, 2, 0, 0},
           {0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3, 0, 0},
           {0.715084780757673, 0.536758777471573, 0.613220446252801, 0.430885529157667, 0.823529411764706}},
          {"worse than chance", {0, 1, 0, 1}, {0, 0, 1, 1}, {0, 0, 0, -0.5, 0.5}},
          {"unrelated",
           t,
           p,
           {0.00820401081523542, 0.00634814663893141, 0.0071577377920112, -0.00187640452323776, 0.296}}};
}

TEST(Agreement, EqualsScikitLearn) {
  for (const Stored& stored : storedCases()) {
    const Agreement found = measureAgreement(stored.truth, stored.clusters);
    EXPECT_THAT((std::vector{found.homogeneity, found.completeness, found.vMeasure, found.adjustedRandIndex,
                             found.purity}),
                testing::Pointwise(testing::DoubleNear(1e-12), stored.measures))
        << stored.name;
  }
}

TEST(Agreement, OfASingleClusterIsCompleteButNotHomogeneousAndNeedsItems) {
  const std::vector<int> truth{1, 1, 2, 3}, one(4, 9);
  const Agreement found = measureAgreement(truth, one);
  EXPECT_DOUBLE_EQ(found.homogeneity, 0);
  EXPECT_DOUBLE_EQ(found.completeness, 1);
  EXPECT_DOUBLE_EQ(found.vMeasure, 0);
  EXPECT_DOUBLE_EQ(found.adjustedRandIndex, 0);
  EXPECT_DOUBLE_EQ(found.purity, 0.5);
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

TEST(KeptNumbers, AreThoseOfTheLargestOverlapAndAreGivenOnce) {
  // Group 0 is what was 2, group 1 what was 0; group 2 is new.
  EXPECT_THAT(keptNumbers(3, {{{0, 2}, 50}, {{0, 0}, 3}, {{1, 0}, 20}}), ElementsAre(2, 0, 1));
  // A split: the larger part keeps the number.
  EXPECT_THAT(keptNumbers(2, {{{0, 0}, 30}, {{1, 0}, 70}}), ElementsAre(1, 0));
  // Merged: the number of what was more of it.
  EXPECT_THAT(keptNumbers(1, {{{0, 1}, 70}, {{0, 0}, 30}}), ElementsAre(0)) << "1 would leave a gap";
  EXPECT_THAT(keptNumbers(3, {}), ElementsAre(0, 1, 2));
  EXPECT_THAT(keptNumbers(0, {}), ElementsAre());
  EXPECT_THAT(keptNumbers(2, {{{7, 0}, 5}, {{0, 9}, 5}}), ElementsAre(0, 1)) << "none of these";
}

// scipy.stats.binomtest(k, n).proportion_ci(method="wilson")
TEST(WilsonInterval, IsSciPysAndRefusesWhatIsNoShare) {
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
  for (const auto& [share, trials] : {std::pair{0.0, 0.0}, {3.0, 2.0}, {1.5, 2.0}, {0.5, 0.0}, {-1.0, 2.0}})
    EXPECT_THAT(([&share = share, &trials = trials] { wilsonInterval(share, trials); }),
                FailsWith(ErrorCode::invalidInput))
        << share;
  EXPECT_THAT([] { wilsonInterval(std::size_t{3}, std::size_t{2}); }, FailsWith(ErrorCode::invalidInput));
}

}  // namespace
}  // namespace estancia
