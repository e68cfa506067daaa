// The large planes of a depth image: tables, walls, floors.
#pragma once

#include <cstdint>
#include <vector>

#include "estancia/cloud/clusters.hpp"
#include "estancia/cloud/inverse_depth.hpp"

namespace estancia {

struct WithoutPlanes {
  std::vector<Plane> planes;  ///< in the order they were found
  Mask rest;                  ///< the pixels with depth that lie on none
};

/// RANSAC (Fischler and Bolles, CACM 1981) in which one pixel with its normal is a hypothesis and square
/// meters are its votes. What lies on a plane must be connected, and face as it does, in patches of half of
/// planeArea at least; the largest must have all of it. Whatever is behind a plane stays.
WithoutPlanes removePlanes(const InverseDepth& grid, const ClusterOptions& options);

}  // namespace estancia
