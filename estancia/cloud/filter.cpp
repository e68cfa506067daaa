#include "estancia/cloud/filter.hpp"

#include <fmt/format.h>

#include <cmath>

#include "estancia/cloud/neighbors.hpp"
#include "estancia/cloud/voxel_grid.hpp"
#include "estancia/core/error.hpp"

namespace estancia {
namespace {

/// Without points that are not finite, and then unorganized.
PointCloud finiteOf(const PointCloud& cloud) {
  PointCloud finite;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const cv::Point3f& p = cloud.points[i];
    if (!isFinite(p)) continue;
    finite.points.push_back(p);
    if (!cloud.colors.empty()) finite.colors.push_back(cloud.colors[i]);
    if (!cloud.normals.empty()) finite.normals.push_back(cloud.normals[i]);
  }
  finite.width = finite.points.size();
  finite.height = 1;
  return finite;
}

FilteredCloud keepAll(const PointCloud& cloud, const FilterOptions&, Progress&) {
  return {cloud, 0, {}};
}

FilteredCloud throughVoxels(const PointCloud& cloud, const FilterOptions& options, Progress&) {
  if (!(options.leaf >= 0) || !std::isfinite(options.leaf))
    throw Error(fmt::format("a voxel cannot have an edge of {} m; give one above 0, or 0 to have it found",
                            options.leaf));
  PointCloud finite = finiteOf(cloud);
  if (options.leaf == 0 && finite.points.size() <= options.points) return {std::move(finite), 0, {}};
  const double leaf = options.leaf > 0 ? options.leaf : findLeaf(finite, options.points).size;
  return {voxelGrid(finite, leaf), leaf, {}};
}

/// For each of `points` the color of the nearest point of the cloud.
std::vector<cv::Vec3b> nearestColors(const std::vector<cv::Point3f>& points, const PointCloud& cloud) {
  std::vector<cv::Vec3b> colors;
  if (cloud.colors.empty()) return colors;
  const Neighbors around(cloud.points);
  std::vector<Neighbor> buffer;
  for (const cv::Point3f& p : points)
    colors.push_back(cloud.colors[around.nearest(p, 1, buffer).front().index]);
  return colors;
}

FilteredCloud throughNeuralGas(const PointCloud& cloud, const FilterOptions& options, Progress& progress) {
  GngOptions gng = options.gng;
  gng.neurons = options.points;
  FilteredCloud filtered;
  filtered.gas = growNeuralGas(cloud, gng, progress);
  std::swap(filtered.cloud, filtered.gas.cloud);
  filtered.cloud.colors = nearestColors(filtered.cloud.points, cloud);
  return filtered;
}

struct Method {
  const char* name;
  const char* explanation;
  FilteredCloud (*apply)(const PointCloud&, const FilterOptions&, Progress&);
};

constexpr Method kMethods[] = {
    {"none", "as it is", keepAll},
    {"voxel", "the mean of the points in each cube of space", throughVoxels},
    {"gng", "Growing Neural Gas: neurons that follow the surface behind noise", throughNeuralGas},
};

}  // namespace

std::vector<std::pair<std::string, std::string>> filterMethods() {
  std::vector<std::pair<std::string, std::string>> methods;
  for (const Method& method : kMethods) methods.emplace_back(method.name, method.explanation);
  return methods;
}

FilteredCloud filterWithDetails(const PointCloud& cloud, const FilterOptions& options, Progress& progress) {
  std::string known;
  for (const Method& method : kMethods) {
    known += fmt::format("{}{}", known.empty() ? "" : ", ", method.name);
    if (options.method != method.name) continue;
    validate(cloud);
    FilteredCloud filtered = method.apply(cloud, options, progress);
    filtered.cloud.viewpoint = cloud.viewpoint;
    if (filtered.cloud.points.empty() && method.apply != keepAll)
      throw Error("the cloud has no point to keep: none is finite");
    return filtered;
  }
  throw Error(fmt::format("there is no filter \"{}\"; known are {}", options.method, known));
}

PointCloud filterCloud(const PointCloud& cloud, const FilterOptions& options, Progress& progress) {
  return filterWithDetails(cloud, options, progress).cloud;
}

}  // namespace estancia
