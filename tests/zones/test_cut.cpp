// τ_d out of the data, beside the definition of modularity.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/zones/image_tree.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

#include "estancia/stats/linkage.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using testing::ElementsAre;

CondensedDistances distancesOf(const std::vector<double>& points) {
  CondensedDistances distances(points.size());
  std::size_t at = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t j = i + 1; j < points.size(); ++j)
      distances.values()[at++] = std::abs(points[i] - points[j]);
  return distances;
}

SuggestedCut suggestionFor(const std::vector<double>& points, std::size_t neighbors = 5) {
  return suggestCut(link(distancesOf(points), Linkage::average),
                    findNeighbors(distancesOf(points), neighbors));
}

TEST(NearestItems, AreTheNearestOfEqualOnesTheFirst) {
  const NearestItems two = findNeighbors(distancesOf({0, 1, 2, 10, 3}), 2);
  EXPECT_EQ(two.each, 2U);
  EXPECT_THAT(two.nearest, ElementsAre(1, 2,    // 0
                                       0, 2,    // 1: both at 1
                                       1, 4,    // 2
                                       4, 2,    // 10
                                       2, 1));  // 3
}

TEST(NearestItems, AreWantedByTheRootOfTheNumberOfItems) {
  EXPECT_EQ(neighborsForCut(1), 3U);
  EXPECT_EQ(neighborsForCut(216), 5U);
  EXPECT_EQ(neighborsForCut(1173), 11U);
}

/// Newman's definition, term by term: Q = 1/W Σ_ij (A_ij − k_i k_j / W) [i and j in one part].
double slowModularity(const NearestItems& neighbors, const std::vector<int>& parts) {
  const std::size_t n = parts.size();
  std::vector<std::vector<double>> weights(n, std::vector<double>(n));
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = 0; k < neighbors.each; ++k) {
      const std::size_t link = i * neighbors.each + k, j = neighbors.nearest[link];
      const double weight = neighbors.weights.empty() ? 1 : neighbors.weights[link];
      weights[i][j] += weight / 2;
      weights[j][i] += weight / 2;
    }
  for (std::size_t i = 0; i < neighbors.within.size(); ++i) weights[i][i] += neighbors.within[i];
  std::vector<double> degrees(n);
  double total = 0, q = 0;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j) {
      degrees[i] += weights[i][j];
      total += weights[i][j];
    }
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j)
      if (parts[i] == parts[j]) q += (weights[i][j] - degrees[i] * degrees[j] / total) / total;
  return q;
}

TEST(SuggestedCut, HasTheLargestModularityOfAllCuts) {
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 4; ++trial) {
    std::vector<double> points;
    std::vector<std::size_t> sizes;
    for (int i = 0; i < 60; ++i) {
      points.push_back(normal(random) + 4.0 * static_cast<double>(random() % 5));
      sizes.push_back(1 + random() % 4);
    }
    for (const Linkage linkage : {Linkage::average, Linkage::single, Linkage::ward}) {
      const Dendrogram tree = link(distancesOf(points), linkage);
      NearestItems neighbors = findNeighbors(distancesOf(points), 5);
      if (trial % 2 == 1) weighBySize(neighbors, sizes);
      double best = 0;
      for (std::size_t count = 1; count <= points.size(); ++count)
        best = std::max(best, slowModularity(neighbors, tree.cutInto(count)));
      const SuggestedCut cut = suggestCut(tree, neighbors);
      EXPECT_NEAR(cut.modularity, best, 1e-9);
      EXPECT_NEAR(slowModularity(neighbors, tree.cutAt(cut.distance)), best, 1e-9) << "the cut that is said";
    }
  }
}

TEST(NearestItems, OfGroupsWeighAsTheirImages) {
  NearestItems neighbors = findNeighbors(distancesOf({0, 1, 3, 7}), 3);
  weighBySize(neighbors, std::vector<std::size_t>{2, 1, 5, 1});
  EXPECT_THAT(neighbors.nearest, ElementsAre(1, 2, 3, 0, 2, 3, 1, 0, 3, 2, 1, 0));
  EXPECT_THAT(neighbors.within, ElementsAre(2, 0, 15, 0));
  EXPECT_THAT(neighbors.weights, ElementsAre(2, 2, 0, 2, 1, 0, 0, 0, 0, 3, 0, 0));
  const std::vector<std::size_t> two{1, 2};
  EXPECT_THAT([&] { weighBySize(neighbors, two); }, FailsWith(ErrorCode::mismatch));
  const Dendrogram ofThree = link(distancesOf({1, 2, 3}), Linkage::average);
  EXPECT_THAT([&] { suggestCut(ofThree, neighbors); }, FailsWith(ErrorCode::mismatch));
}

TEST(SuggestedCut, LeavesTogetherWhatIsAlikeOrTooFew) {
  for (const std::vector<double>& points :
       {std::vector<double>(20, 1.0), std::vector<double>{1}, std::vector<double>{1, 2, 3, 50}}) {
    const SuggestedCut cut = suggestionFor(points);
    const std::vector<int> groups = link(distancesOf(points), Linkage::average).cutAt(cut.distance);
    EXPECT_EQ(std::set<int>(groups.begin(), groups.end()).size(), 1U);
    EXPECT_EQ(cut.modularity, 0);
  }
}

}  // namespace
}  // namespace estancia
