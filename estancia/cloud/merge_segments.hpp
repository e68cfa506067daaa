// Pieces of a depth image that are one thing although they do not touch in the image.
#pragma once

#include "estancia/cloud/inverse_depth.hpp"
#include "estancia/cloud/segments.hpp"

namespace estancia {

/// Joins pieces that come within `contact` [m] of each other without a concave corner between them (a hole or
/// the rim of the nearer one lies between them in the image), and pieces of one surface with something
/// nearer in between that hides what connects them.
void mergeSegments(const InverseDepth& grid, const Mask& mask, double contact, int threads,
                   Segmentation& pieces);

}  // namespace estancia
