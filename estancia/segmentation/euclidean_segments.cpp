// Euclidean clusters: R. B. Rusu, Semantic 3D Object Maps for Everyday Manipulation (2009), 6.2.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "estancia/cloud/disjoint_sets.hpp"
#include "estancia/cloud/neighbors.hpp"
#include "estancia/cloud/voxel_grid.hpp"
#include "estancia/segmentation/segmentation_stages.hpp"

namespace estancia {

// Voxels, distances and sizes are those of the program of the thesis' author, SEFTDescriptor.
std::pair<Segmentation, Mask> euclideanSegments(const InverseDepth& grid, const std::vector<Plane>& planes,
                                                int threads) {
  PointCloud rest;
  std::vector<std::size_t> pixels;
  std::vector<std::uint8_t> in(grid.size());
  for (int v = 0; v < grid.camera.height; ++v)
    for (int u = 0; u < grid.camera.width; ++u) {
      if (!(grid.raw[grid.at(u, v)] > 0)) continue;
      const cv::Point3f p = grid.point(u, v);
      if (std::ranges::any_of(planes, [&p](const Plane& plane) {
            return std::abs(plane.normal.dot({p.x, p.y, p.z}) - plane.offset) <= 0.02;  // [m]
          }))
        continue;
      rest.points.push_back(p);
      pixels.push_back(grid.at(u, v));
      in[grid.at(u, v)] = 1;
    }
  rest.width = rest.points.size();
  rest.height = 1;
  const PointCloud voxels = voxelGrid(rest, 0.005);  // [m]
  const Neighbors tree(voxels.points, threads);
  DisjointSets sets(voxels.points.size());
  std::vector<Neighbor> buffer;
  for (std::uint32_t i = 0; i < voxels.points.size(); ++i)
    for (const Neighbor& other : tree.within(voxels.points[i], 0.015F, buffer))  // [m]
      sets.join(i, other.index);
  std::vector<std::uint32_t> sizes(voxels.points.size()), numbers(voxels.points.size());
  for (std::uint32_t i = 0; i < sizes.size(); ++i) ++sizes[sets.find(i)];
  Segmentation segments{std::vector<std::uint32_t>(grid.size()), {0}, {}};
  for (std::uint32_t i = 0; i < sizes.size(); ++i) {
    if (sizes[i] < 100 || sizes[i] > 25'000) continue;  // voxels
    numbers[i] = static_cast<std::uint32_t>(segments.sizes.size());
    segments.sizes.push_back(0);
  }
  for (std::size_t k = 0; k < pixels.size(); ++k) {
    const std::uint32_t number = numbers[sets.find(tree.nearest(rest.points[k], 1, buffer).front().index)];
    segments.labels[pixels[k]] = number;
    ++segments.sizes[number];
  }
  return {std::move(segments), Mask(grid, std::move(in))};
}

}  // namespace estancia
