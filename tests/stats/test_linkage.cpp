#include "estancia/stats/linkage.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include "estancia/core/error.hpp"

namespace estancia {
namespace {

using Matrix = std::vector<std::vector<double>>;

Matrix squareOf(const CondensedDistances& distances) {
  const std::size_t n = distances.items();
  Matrix matrix(n, std::vector<double>(n, 0));
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
std::vector<double> slowHeights(const Matrix& items, Linkage linkage) {
  struct Cluster {
    std::vector<std::size_t> items;
    std::vector<std::vector<std::size_t>> halves;  // those that it was made of
  };
  std::vector<Cluster> clusters;
  for (std::size_t i = 0; i < items.size(); ++i) clusters.push_back({{i}, {}});
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

class EveryLinkage : public testing::TestWithParam<NamedLinkage> {
 protected:
  const Linkage linkage_ = GetParam().linkage;
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

INSTANTIATE_TEST_SUITE_P(Linkage, EveryLinkage, testing::ValuesIn(linkages()),
                         [](const auto& named) { return named.param.name; });

}  // namespace
}  // namespace estancia
