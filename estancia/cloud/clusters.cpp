#include "estancia/cloud/clusters.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "estancia/cloud/inverse_depth.hpp"
#include "estancia/cloud/joins.hpp"
#include "estancia/cloud/pieces.hpp"
#include "estancia/cloud/planes.hpp"
#include "estancia/core/error.hpp"

namespace estancia {
namespace {

void requireSound(const ClusterOptions& options) {
  const auto positive = [](const char* name, double value) {
    if (!(value > 0) || !std::isfinite(value))
      throw Error(fmt::format("{} cannot be {}; give a number above 0", name, value));
  };
  positive("the area of a plane", options.planeArea);
  positive("the tolerance of a plane", options.planeTolerance);
  positive("the depth of a crease", options.crease);
  positive("the distance of pieces that touch", options.join);
  if (options.threads < 0)
    throw Error(fmt::format("{} threads are none; give 0 for as many as there are cores", options.threads));
}

std::vector<Cluster> clustersOf(const InverseDepth& grid, const Pieces& pieces, std::size_t least) {
  const double enough = std::max(1., grid.area(static_cast<double>(least)));
  std::vector<Cluster> clusters;
  std::vector<std::uint32_t> numbers(pieces.sizes.size());
  for (std::size_t i = 1; i < pieces.sizes.size(); ++i) {
    if (pieces.sizes[i] < enough) continue;
    numbers[i] = static_cast<std::uint32_t>(clusters.size() + 1);
    clusters.emplace_back().points.reserve(pieces.sizes[i]);
  }
  for (int v = 0; v < grid.camera.height; ++v)
    for (int u = 0; u < grid.camera.width; ++u) {
      const std::uint32_t number = numbers[pieces.labels[grid.at(u, v)]];
      if (number != 0)
        clusters[number - 1].points.push_back(static_cast<std::uint32_t>(v * grid.camera.width + u));
    }
  std::ranges::stable_sort(clusters, std::ranges::greater{},
                           [](const Cluster& c) { return c.points.size(); });
  return clusters;
}

}  // namespace

Clusters findClusters(const cv::Mat& depth, const CameraIntrinsics& camera, const ClusterOptions& options) {
  requireSound(options);
  const InverseDepth grid = inverseDepth(depth, camera, options.threads);
  WithoutPlanes scene = removePlanes(grid, options);
  std::vector<std::uint8_t> creases = concaveCreases(grid, scene.rest, options.crease, options.threads);
  Pieces pieces = cutPieces(grid, scene.rest, std::move(creases));
  joinPieces(grid, options.join, pieces);
  joinVessels(grid, scene.planes, pieces);
  return {std::move(scene.planes), clustersOf(grid, pieces, options.least)};
}

}  // namespace estancia
