// Unorganized clouds: object segmentation from the points alone.
#pragma once

#include "estancia/cloud/clusters.hpp"
#include "estancia/core/point_cloud.hpp"

namespace estancia {

/// findClusters() from the points alone, thinned to one a voxel of 5 mm or two spacings. Concave creases
/// separate objects where the visible side of the surface is known: the cloud has normals or a viewpoint, or
/// the origin, the default position of a sensor, lies outside of it. Otherwise each connected component is an
/// object.
Clusters findUnorganizedClusters(const PointCloud& cloud, const ClusterOptions& options);

}  // namespace estancia
