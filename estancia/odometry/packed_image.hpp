// Packed RGB-D image: gray values in 8 bits and depth in 16, as keyframes are kept and stored.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>

#include "estancia/core/bytes.hpp"
#include "estancia/core/camera.hpp"
#include "estancia/odometry/pyramid.hpp"

namespace estancia::odometry {

struct PackedImage {
  CameraIntrinsics camera;
  cv::Mat gray;     ///< CV_8U
  cv::Mat depth;    ///< CV_16U, same size; 0 where there is none
  double step = 0;  ///< step of depth [m]
};

/// Depth up to `maxDepth` [m] in 65535 steps: 0.12 mm of 8 m.
PackedImage packed(const RgbdImage& image, double maxDepth);
RgbdImage unpacked(const PackedImage& image);

/// Writes two PNG files, without loss.
void write(const PackedImage& image, ByteWriter& bytes);
/// Throws Error (malformedFile).
PackedImage readPackedImage(ByteReader& bytes);

/// The six numbers of a camera.
void write(const CameraIntrinsics& camera, ByteWriter& bytes);
/// Throws Error (malformedFile).
CameraIntrinsics readCamera(ByteReader& bytes);

}  // namespace estancia::odometry
