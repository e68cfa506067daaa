// Segment merging: parts of one object that are not adjacent in the depth image.
#pragma once

#include "estancia/cloud/inverse_depth.hpp"
#include "estancia/cloud/segments.hpp"

namespace estancia {

/// Merges segments that come within `contact` [m] of each other without a concave corner between them (a hole
/// or the rim of the nearer one separates them in the image), and segments of one surface that an occluder
/// separates.
void mergeSegments(const InverseDepth& grid, const Mask& mask, double contact, int threads,
                   Segmentation& segments);

}  // namespace estancia
