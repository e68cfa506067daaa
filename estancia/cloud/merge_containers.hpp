// Bowls, mugs and pots: their inside belongs to their wall.
#pragma once

#include <vector>

#include "estancia/cloud/clusters.hpp"
#include "estancia/cloud/inverse_depth.hpp"
#include "estancia/cloud/segments.hpp"

namespace estancia {

/// Joins what lies within the round wall of a vessel that stands on one of `planes`: its inside.
void mergeContainerInteriors(const InverseDepth& grid, const Mask& mask, const std::vector<Plane>& planes,
                             int threads, Segmentation& pieces);

}  // namespace estancia
