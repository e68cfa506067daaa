// Camera intrinsics files: `fx fy cx cy`, a camera matrix, or a ROS or OpenCV calibration.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "estancia/core/camera.hpp"

namespace estancia::io {

/// Reads `fx fy cx cy`, a 3×3 or 4×4 camera matrix (numbers separated by blanks or commas, `#` starts a
/// comment), or a YAML calibration as ROS (`camera_matrix` with `data`, or `K`) and OpenCV write it. Width
/// and height are 0 where the file lacks them. Distortion is not read: images are expected to be rectified.
/// Throws Error when it is none of these or no camera (focal lengths not above 0, skewed, transposed …).
CameraIntrinsics readIntrinsics(const std::filesystem::path& file);

/// The usual intrinsics file of a folder: camera-intrinsics.txt, intrinsics.txt or camera.yaml; "" without.
std::filesystem::path findIntrinsics(const std::filesystem::path& folder);

}  // namespace estancia::io
