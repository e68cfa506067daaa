// Pinhole camera intrinsics: focal lengths, principal point and image size, in pixels.
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace estancia {

/// A pinhole camera without distortion: the point (X, Y, Z) in its optical frame (x right, y down, z forward;
/// meters) is seen at u = fx X / Z + cx, v = fy Y / Z + cy, in pixels of an image of width × height whose
/// first pixel has its center at (0, 0).
struct CameraIntrinsics {
  int width = 0, height = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;

  /// X / Z of what is seen in column u, and Y / Z of what is seen in row v.
  double slopeX(double u) const { return (u - cx) / fx; }
  double slopeY(double v) const { return (v - cy) / fy; }

  /// This camera with images of another size (color and depth often differ in it).
  CameraIntrinsics scaledTo(int newWidth, int newHeight) const {
    const double sx = static_cast<double>(newWidth) / width, sy = static_cast<double>(newHeight) / height;
    return {newWidth, newHeight, fx * sx, fy * sy, (cx + 0.5) * sx - 0.5, (cy + 0.5) * sy - 0.5};
  }
};

}  // namespace estancia
