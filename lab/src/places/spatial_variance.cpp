// SPDX-License-Identifier: Apache-2.0
#include "places/spatial_variance.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <map>

#include "estancia/core/error.hpp"

namespace estancia::experiments {
namespace {

struct Cluster {
  double count = 0;
  Position mean{};
  double squares = 0;  // Σ of squared distances to the mean (Welford 1962)

  void add(const Position& p) {
    ++count;
    for (std::size_t axis = 0; axis < p.size(); ++axis) {
      const double before = p[axis] - mean[axis];
      mean[axis] += before / count;
      squares += before * (p[axis] - mean[axis]);
    }
  }
};

}  // namespace

SpatialVariance spatialVariance(std::span<const Position> positions, std::span<const int> clusters) {
  if (positions.empty() || positions.size() != clusters.size())
    throw Error(ErrorCode::mismatch,
                fmt::format("{} positions for {} clustered items: give one each, and at least one",
                            positions.size(), clusters.size()));
  std::map<int, Cluster> byName;
  for (std::size_t i = 0; i < positions.size(); ++i) byName[clusters[i]].add(positions[i]);
  SpatialVariance result;
  for (const auto& [name, cluster] : byName) {
    result.overClusters += cluster.squares / cluster.count / static_cast<double>(byName.size());
    result.overItems += cluster.squares / static_cast<double>(positions.size());
  }
  return result;
}

}  // namespace estancia::experiments
