// SPDX-License-Identifier: Apache-2.0
#include "estancia/cloud/filter.hpp"

#include <utility>

#include "estancia/cloud/voxel_grid.hpp"
#include "estancia/core/error.hpp"

namespace estancia {
OptionGroup declare(FilterOptions& o) {
  OptionGroup group("filter", "Point cloud filter.");
  group.add("method", &o.method, "Filter").choices(filterMethods());
  group.add("points", &o.points, "Points of the result").range(1);
  group.add("leaf", &o.leaf, "Edge of a voxel")
      .range(0)
      .unit("m")
      .automatic("the one that leaves the points");
  OptionGroup gng = declare(o.gng);
  std::erase_if(gng.options(), [](const Option& option) { return option.name() == "neurons"; });
  group.add(std::move(gng));
  return group;
}

Choices filterMethods() {
  return {{"none", "the cloud unchanged"},
          {"voxel", "the mean of the points in each voxel"},
          {"gng", "Growing Neural Gas: neurons fitted to the surface behind the noise"}};
}

FilteredCloud filterWithDetails(const PointCloud& cloud, const FilterOptions& options, Progress& progress) {
  validate(options);
  validate(cloud);
  FilteredCloud filtered;
  if (options.method == "none") {
    filtered.cloud = cloud;
    return filtered;
  }
  if (options.method == "gng") {
    GngOptions gng = options.gng;
    gng.neurons = options.points;
    filtered.gas = growNeuralGas(cloud, gng, progress);
    std::swap(filtered.cloud, filtered.gas.cloud);
  } else {
    filtered.cloud = finitePoints(cloud);
    if (options.leaf > 0 || filtered.cloud.points.size() > options.points) {
      filtered.leaf = options.leaf > 0 ? options.leaf : findLeaf(filtered.cloud, options.points).size;
      filtered.cloud = voxelGrid(filtered.cloud, filtered.leaf);
    }
  }
  filtered.cloud.viewpoint = cloud.viewpoint;
  if (filtered.cloud.points.empty())
    throw Error(ErrorCode::invalidInput, "no point of the cloud is finite, so the filter has none to keep");
  return filtered;
}

PointCloud filterCloud(const PointCloud& cloud, const FilterOptions& options, Progress& progress) {
  return filterWithDetails(cloud, options, progress).cloud;
}

}  // namespace estancia
