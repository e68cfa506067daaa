// RGB-D image: its pyramid, and the packed form in which keyframes are kept and stored.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "estancia/core/bytes.hpp"
#include "estancia/core/camera.hpp"

namespace estancia::odometry {

/// Gray values and depth of one frame.
struct RgbdImage {
  CameraIntrinsics camera;
  cv::Mat gray;   ///< CV_32F, 0 to 1
  cv::Mat depth;  ///< CV_32F [m], same size; 0 where there is none
};

/// One level and its derivatives; everything CV_32F (or CV_32FC3), contiguous, NaN
/// where there is no depth.
struct PyramidLevel {
  CameraIntrinsics camera;
  cv::Mat gray, depth, points, normals, grayDx, grayDy;
};

/// From the finest to the coarsest.
using Pyramid = std::vector<PyramidLevel>;

/// Whether both have the same aspect ratio within 2 %, as depth and image of the same view do.
bool sameShape(cv::Size a, cv::Size b);

/// The image in depth's size, halved until it is at most `width` wide. `camera` is that of `depth` (meters,
/// CV_32F); depth beyond `maxDepth` [m] counts as missing. `bgr` shows the same view in any size.
RgbdImage reducedImage(const cv::Mat& bgr, const cv::Mat& depth, const CameraIntrinsics& camera, int width,
                       double maxDepth);

/// At most `levels` sizes, none less than 24 pixels wide or high.
Pyramid pyramidOf(const RgbdImage& image, int levels);

/// Gray values in 8 bits and depth in 16.
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
