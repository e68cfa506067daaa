// RGB-D image pyramid: gray values, depth, points, normals and gradients at several sizes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

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
  cv::Mat gray, depth, points, normals;
  cv::Mat grayDx, grayDy, depthDx, depthDy;
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

}  // namespace estancia::odometry
