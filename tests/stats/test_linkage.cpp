// SPDX-License-Identifier: Apache-2.0
#include "estancia/stats/linkage.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <limits>
#include <random>
#include <set>
#include <utility>

#include "support/errors.hpp"

namespace estancia {

void PrintTo(const Choice& linkage, std::ostream* out) {
  *out << linkage.name;
}

namespace {

using test::FailsWith;
using SquareMatrix = std::vector<std::vector<double>>;

SquareMatrix squareOf(const CondensedDistances& distances) {
  const std::size_t n = distances.items();
  SquareMatrix matrix(n, std::vector<double>(n, 0));
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j) matrix[i][j] = matrix[j][i] = distances(i, j);
  return matrix;
}

CondensedDistances copyOf(const CondensedDistances& distances) {
  CondensedDistances copy(distances.items());
  std::copy(distances.values().begin(), distances.values().end(), copy.values().begin());
  return copy;
}

/// The textbook: look at all pairs of clusters, merge the nearest two, compute the new cluster's distances
/// from the items (Ward: from the formula over the first distances), until one is left. O(n³) and more.
std::vector<double> slowHeights(const SquareMatrix& items, Linkage linkage) {
  struct Cluster {
    std::vector<std::size_t> items;
  };
  std::vector<Cluster> clusters;
  for (std::size_t i = 0; i < items.size(); ++i) clusters.push_back({{i}});
  // WPGMA remembers how clusters came about: the weight of each item.
  std::vector<double> weight(items.size(), 1);
  const auto squares = [&](const Cluster& a, const Cluster& b) {
    double sum = 0;
    for (const std::size_t i : a.items)
      for (const std::size_t j : b.items) sum += items[i][j] * items[i][j];
    return sum / static_cast<double>(a.items.size() * b.items.size());
  };
  const auto distance = [&](const Cluster& a, const Cluster& b) {
    double sum = 0, most = 0, least = std::numeric_limits<double>::infinity(), weighted = 0;
    for (const std::size_t i : a.items)
      for (const std::size_t j : b.items) {
        sum += items[i][j];
        most = std::max(most, items[i][j]);
        least = std::min(least, items[i][j]);
        weighted += weight[i] * weight[j] * items[i][j];
      }
    const auto n = static_cast<double>(a.items.size()), m = static_cast<double>(b.items.size());
    switch (linkage) {
      case Linkage::single:
        return least;
      case Linkage::complete:
        return most;
      case Linkage::average:
        return sum / (n * m);
      case Linkage::weighted:
        return weighted;
      case Linkage::ward:  // squared distance of the means out of all squared distances
        return std::sqrt(
            std::max(0.0, 2 * n * m / (n + m) * (squares(a, b) - squares(a, a) / 2 - squares(b, b) / 2)));
    }
    return 0.0;
  };
  std::vector<double> heights;
  while (clusters.size() > 1) {
    std::size_t a = 0, b = 1;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < clusters.size(); ++i)
      for (std::size_t j = i + 1; j < clusters.size(); ++j)
        if (const double d = distance(clusters[i], clusters[j]); d < least) {
          a = i;
          b = j;
          least = d;
        }
    heights.push_back(least);
    Cluster& kept = clusters[a];
    kept.items.insert(kept.items.end(), clusters[b].items.begin(), clusters[b].items.end());
    for (const std::size_t i : kept.items) weight[i] /= 2;
    clusters.erase(clusters.begin() + static_cast<std::ptrdiff_t>(b));
  }
  return heights;
}

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

class EveryLinkage : public testing::TestWithParam<Choice> {
 protected:
  const Linkage linkage_ = getLinkage(GetParam().name);
};

TEST_P(EveryLinkage, HasTheHeightsOfTheTextbook) {
  for (const std::size_t n : {2U, 3U, 4U, 5U, 10U, 40U, 90U, 200U}) {
    const CondensedDistances distances = euclidean(n, static_cast<unsigned>(n));
    const std::vector<double> expected = slowHeights(squareOf(distances), linkage_);
    const Dendrogram dendrogram = link(copyOf(distances), linkage_);
    ASSERT_EQ(dendrogram.merges().size(), n - 1);
    for (std::size_t k = 0; k + 1 < n; ++k)
      EXPECT_NEAR(dendrogram.merges()[k].height, expected[k], 1e-6) << n << " items, merge " << k;
  }
}

TEST_P(EveryLinkage, KnowsFewItems) {
  for (const std::size_t n : {0U, 1U}) {
    const Dendrogram dendrogram = link(CondensedDistances(n), linkage_);
    EXPECT_TRUE(dendrogram.merges().empty());
    EXPECT_EQ(dendrogram.cutAt(1), std::vector<int>(n, 0));
    EXPECT_EQ(dendrogram.cutInto(n), std::vector<int>(n, 0));
  }
  CondensedDistances two(2);
  two.values()[0] = 0.25;
  const Dendrogram dendrogram = link(std::move(two), linkage_);
  EXPECT_EQ(dendrogram.cutAt(0.2), (std::vector<int>{0, 1}));
  EXPECT_EQ(dendrogram.cutAt(0.25), (std::vector<int>{0, 0})) << "merging stops above the distance";
}

TEST_P(EveryLinkage, RefusesWhatIsNoDistance) {
  for (const double bad : {std::nan(""), -0.5, 1e300, std::numeric_limits<double>::infinity()}) {
    CondensedDistances distances = euclidean(6, 1);
    distances.after(2)[1] = bad;
    EXPECT_THAT([&] { link(std::move(distances), linkage_); }, FailsWith(ErrorCode::invalidInput));
  }
}

INSTANTIATE_TEST_SUITE_P(Linkage, EveryLinkage, testing::ValuesIn(linkages()),
                         [](const auto& named) { return named.param.name; });

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

TEST(ComparisonFor, IsTheDistancesOwnButForWard) {
  EXPECT_EQ(comparisonFor(getDistance("clr-cosine"), Linkage::average), Comparison::cosine);
  EXPECT_EQ(comparisonFor(getDistance("clr-cosine"), Linkage::ward), Comparison::euclidean);
  EXPECT_EQ(comparisonFor(getDistance("hellinger"), Linkage::ward), Comparison::euclidean);
  EXPECT_EQ(comparisonFor(getDistance("ks"), Linkage::average), Comparison::chebyshev);
}

TEST(ComparisonFor, RefusesWhatDoesNotFitAndNamesWhatDoes) {
  for (const char* name : {"ks", "l1", "chi2", "kullback-leibler", "bhattacharyya"})
    EXPECT_THAT([&] { comparisonFor(getDistance(name), Linkage::ward); },
                FailsWith(ErrorCode::invalidOption));
  for (const char* name : {"ks-sigma", "weighted", "weighted-root"})
    EXPECT_THAT([&] { comparisonFor(getDistance(name), Linkage::average); },
                FailsWith(ErrorCode::invalidOption));
}

TEST(Dendrogram, IsCutByDistanceAndByNumber) {
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
}

TEST(Dendrogram, RefusesMergesThatDoNotFollow) {
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

}  // namespace
}  // namespace estancia
