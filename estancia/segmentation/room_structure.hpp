// Room structure: which way is up, and which planes of a depth image are floor, walls and ceiling.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/matx.hpp>
#include <vector>

#include "estancia/segmentation/clusters.hpp"
#include "estancia/segmentation/inverse_depth.hpp"
#include "estancia/segmentation/segmentation_stages.hpp"

namespace estancia {

/// Up, in the optical frame, as a unit vector: the direction within 60° of the image's up to which planes of
/// the largest area are parallel or perpendicular (Manhattan world; Coughlan and Yuille, ICCV 1999). The
/// image's up if there is no such plane.
cv::Vec3d upOf(const std::vector<Plane>& planes);

/// Sets Plane::structural. Level and sloping planes bound the room when nearly nothing is seen behind them:
/// the floor, but not the top of a table beside which the floor is seen. Upright planes are walls, unless
/// their upper edge is seen before what lies far behind it, or another plane, parallel and behind them by the
/// depth of furniture, is the wall that they stand at; and then so are the other faces of the thing, where
/// its surface turns convexly from one into the other. Upright planes as narrow as a wall is thick are the
/// walls' ends.
void findStructure(const InverseDepth& grid, const cv::Vec3d& up, PlaneRemoval& removal);

}  // namespace estancia
