// Container merging: the interior of a bowl, mug or pot joins its wall.
#pragma once

#include <vector>

#include "estancia/cloud/clusters.hpp"
#include "estancia/cloud/inverse_depth.hpp"
#include "estancia/cloud/segments.hpp"

namespace estancia {

/// Merges the segments inside of the round wall of a container that stands on one of `planes` with the wall.
void mergeContainerInteriors(const InverseDepth& grid, const Mask& mask, const std::vector<Plane>& planes,
                             int threads, Segmentation& segments);

}  // namespace estancia
