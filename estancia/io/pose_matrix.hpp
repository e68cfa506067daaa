// Pose from a matrix: rigid 3×4 transform to position and unit quaternion.
#pragma once

#include <array>
#include <optional>

#include "estancia/core/pose.hpp"

namespace estancia::io {

/// The pose of a rigid transform camera → map, row-major 3×4. Nothing when it is not finite or its left part
/// is no rotation (columns off by more than 1 % from unit length or right angles, or mirrored).
std::optional<Pose> poseOfMatrix(const std::array<double, 12>& matrix);

}  // namespace estancia::io
