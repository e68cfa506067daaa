// Clusters of a cloud without a grid.
#pragma once

#include "estancia/cloud/clusters.hpp"
#include "estancia/core/point_cloud.hpp"

namespace estancia {

/// findClusters() by the points alone, thinned to one a voxel of 5 mm or two spacings. Concave creases part
/// things where it is known which side of the surface was seen: the cloud has normals, or a viewpoint, or the
/// origin, where a sensor is by default, lies outside of it. Else things are what is connected.
Clusters findUnorganizedClusters(const PointCloud& cloud, const ClusterOptions& options);

}  // namespace estancia
