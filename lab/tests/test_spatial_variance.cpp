// SPDX-License-Identifier: Apache-2.0
#include "places/spatial_variance.hpp"
#include "support/errors.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

namespace estancia::experiments {
namespace {

using test::FailsWith;

/// Made without a generator so that Python makes the same: u = (1103515245·i + 12345) % 65536 / 65536,
/// v = (22695477·i + 1) % 65536 / 65536; P = (10 u, 5 v, u v).
std::vector<Position> positions() {
  std::vector<Position> result;
  for (std::int64_t i = 0; i < 90; ++i) {
    const double u = static_cast<double>((1103515245 * i + 12345) % 65536) / 65536;
    const double v = static_cast<double>((22695477 * i + 1) % 65536) / 65536;
    result.push_back({10 * u, 5 * v, u * v});
  }
  return result;
}

TEST(SpatialVariance, EqualsNumPy) {
  // numpy: mean([P[c == j].var(0).sum() for j in set(c)]), sum of ((P[c == j] - P[c == j].mean(0))**2) / 90
  std::vector<int> even(90), uneven(90);
  for (int i = 0; i < 90; ++i) {
    even[static_cast<std::size_t>(i)] = i % 3;
    uneven[static_cast<std::size_t>(i)] = i < 2 ? 0 : i < 30 ? 5 : -3;
  }
  const SpatialVariance a = spatialVariance(positions(), even), b = spatialVariance(positions(), uneven);
  EXPECT_NEAR(a.overClusters, 10.280802522665994, 1e-12);
  EXPECT_NEAR(a.overItems, 10.280802522665994, 1e-12);
  EXPECT_NEAR(b.overClusters, 7.974987583801706, 1e-12);
  EXPECT_NEAR(b.overItems, 10.27057966184324, 1e-12);
}

TEST(SpatialVariance, OfSingletonsIsNothing) {
  const std::vector<Position> three{{1, 2, 3}, {4, 5, 6}, {7, 8, 10}};
  const SpatialVariance found = spatialVariance(three, std::vector<int>{2, 1, 0});
  EXPECT_EQ(found.overClusters, 0);
  EXPECT_EQ(found.overItems, 0);
}

TEST(SpatialVariance, StraySingletonsSweetenTheMeanOverClustersOnly) {
  const std::vector<Position> five{{0, 0, 0}, {2, 0, 0}, {0, 0, 0}, {2, 0, 0}, {9, 9, 9}};
  const SpatialVariance found = spatialVariance(five, std::vector<int>{0, 0, 0, 0, 1});
  EXPECT_DOUBLE_EQ(found.overClusters, 0.5);
  EXPECT_DOUBLE_EQ(found.overItems, 0.8);
}

TEST(SpatialVariance, NeedsOneClusterAPosition) {
  EXPECT_THAT([&] { spatialVariance({}, {}); }, FailsWith(ErrorCode::mismatch));
  EXPECT_THAT([&] { spatialVariance(positions(), std::vector<int>(89)); }, FailsWith(ErrorCode::mismatch));
}

}  // namespace
}  // namespace estancia::experiments
