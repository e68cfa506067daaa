// Segmentation stages: the steps of findClusters() that remove planes and merge segments.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "estancia/cloud/clusters.hpp"
#include "estancia/cloud/inverse_depth.hpp"
#include "estancia/cloud/segments.hpp"

namespace estancia {

struct PlaneRemoval {
  std::vector<Plane> planes;  ///< in the order they were found
  Mask rest;                  ///< the pixels with depth that lie on none
};

/// Plane removal: sequential RANSAC (Fischler and Bolles, CACM 1981) for the large planes of a depth image
/// (tables, walls, floors), in which one pixel with its normal is a hypothesis and areas are votes. The
/// pixels of a plane must be connected and have its normal, in patches of at least half of minPlaneArea; the
/// largest patch must have all of it. Pixels behind a plane stay.
PlaneRemoval removePlanes(const InverseDepth& grid, const ClusterOptions& options);

/// Segment merging: merges segments that come within `contact` [m] of each other without a concave corner
/// between them (a hole or the rim of the nearer one separates them in the image), and segments of one
/// surface that an occluder separates.
void mergeSegments(const InverseDepth& grid, const Mask& mask, double contact, int threads,
                   Segmentation& segments);

/// Container merging: merges the segments inside of the round wall of a container (bowl, mug, pot) that
/// stands on one of `planes` with the wall.
void mergeContainerInteriors(const InverseDepth& grid, const Mask& mask, const std::vector<Plane>& planes,
                             int threads, Segmentation& segments);

/// findClusters() from the points alone, thinned to one a voxel of 5 mm or two spacings. Concave creases
/// separate objects where the visible side of the surface is known: the cloud has normals or a viewpoint, or
/// the origin, the default position of a sensor, lies outside of it. Otherwise each connected component is an
/// object.
Clusters findUnorganizedClusters(const PointCloud& cloud, const ClusterOptions& options);

}  // namespace estancia
