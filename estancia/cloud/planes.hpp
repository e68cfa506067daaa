// Plane removal: RANSAC for the large planes of a depth image (tables, walls, floors).
#pragma once

#include <cstdint>
#include <vector>

#include "estancia/cloud/clusters.hpp"
#include "estancia/cloud/inverse_depth.hpp"

namespace estancia {

struct PlaneRemoval {
  std::vector<Plane> planes;  ///< in the order they were found
  Mask rest;                  ///< the pixels with depth that lie on none
};

/// Sequential RANSAC (Fischler and Bolles, CACM 1981), in which one pixel with its normal is a hypothesis and
/// areas are votes. The pixels of a plane must be connected and have its normal, in patches of at least half
/// of minPlaneArea; the largest patch must have all of it. Pixels behind a plane stay.
PlaneRemoval removePlanes(const InverseDepth& grid, const ClusterOptions& options);

}  // namespace estancia
