// SPDX-License-Identifier: Apache-2.0
#include "estancia/cloud/filter.hpp"

#include <algorithm>
#include <utility>

#include "estancia/cloud/voxel_grid.hpp"
#include "estancia/core/error.hpp"

namespace estancia {
namespace {

FilteredCloud keepAll(const PointCloud& cloud, const FilterOptions&, Progress&) {
  return {cloud, 0, {}};
}

FilteredCloud throughVoxels(const PointCloud& cloud, const FilterOptions& options, Progress&) {
  PointCloud finite = finitePoints(cloud);
  if (options.leaf == 0 && finite.points.size() <= options.points) return {std::move(finite), 0, {}};
  const double leaf = options.leaf > 0 ? options.leaf : findLeaf(finite, options.points).size;
  return {voxelGrid(finite, leaf), leaf, {}};
}

FilteredCloud throughNeuralGas(const PointCloud& cloud, const FilterOptions& options, Progress& progress) {
  GngOptions gng = options.gng;
  gng.neurons = options.points;
  FilteredCloud filtered;
  filtered.gas = growNeuralGas(cloud, gng, progress);
  std::swap(filtered.cloud, filtered.gas.cloud);
  return filtered;
}

struct Method {
  const char* name;
  const char* explanation;
  FilteredCloud (*apply)(const PointCloud&, const FilterOptions&, Progress&);
};

constexpr Method methodTable[] = {
    {"none", "the cloud unchanged", keepAll},
    {"voxel", "the mean of the points in each voxel", throughVoxels},
    {"gng", "Growing Neural Gas: neurons fitted to the surface behind the noise", throughNeuralGas},
};

}  // namespace

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
  Choices methods;
  for (const Method& method : methodTable) methods.push_back({method.name, method.explanation});
  return methods;
}

FilteredCloud filterWithDetails(const PointCloud& cloud, const FilterOptions& options, Progress& progress) {
  validate(options);
  validate(cloud);
  const Method& method = *std::ranges::find(methodTable, options.method, &Method::name);
  FilteredCloud filtered = method.apply(cloud, options, progress);
  filtered.cloud.viewpoint = cloud.viewpoint;
  if (filtered.cloud.points.empty() && method.apply != keepAll)
    throw Error(ErrorCode::invalidInput, "no point of the cloud is finite, so the filter has none to keep");
  return filtered;
}

PointCloud filterCloud(const PointCloud& cloud, const FilterOptions& options, Progress& progress) {
  return filterWithDetails(cloud, options, progress).cloud;
}

}  // namespace estancia
