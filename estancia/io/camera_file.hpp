// A camera's intrinsics as text.
#pragma once

#include <filesystem>

#include "estancia/core/camera.hpp"

namespace estancia::io {

/// Reads `fx fy cx cy`, a 3×3 or 4×4 camera matrix (numbers apart by blanks or commas, `#` starts a comment),
/// or a YAML calibration as ROS (`camera_matrix` with `data`, or `K`) and OpenCV write it. Width and height
/// are 0 where the file does not say them. Distortion is not read: images are expected to be rectified.
/// Throws Error naming the file when it is none of these or the numbers make no camera (focal lengths not
/// above 0, skewed, transposed, not finite).
CameraIntrinsics readIntrinsics(const std::filesystem::path& file);

/// The file that usually holds the intrinsics of a folder's images: camera-intrinsics.txt, intrinsics.txt
/// or camera.yaml; "" when there is none.
std::filesystem::path findIntrinsics(const std::filesystem::path& folder);

}  // namespace estancia::io
