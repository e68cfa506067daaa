// Frame view: one RGB-D image, ready to be aligned with others.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/affine.hpp>
#include <string>

#include "estancia/odometry/features.hpp"
#include "estancia/odometry/packed_image.hpp"
#include "estancia/odometry/pyramid.hpp"
#include "estancia/odometry/rgbd.hpp"

namespace estancia::odometry {

struct FrameView {
  std::string problem;  ///< why it cannot be aligned; "" when it can
  PackedImage image;
  Pyramid pyramid;  ///< pyramid of `image`
  Features features;
};

/// Makes a view of `bgr` (8 bits) and `depth` [m, CV_32F], in any sizes; `camera` is scaled to both. What is
/// wrong with them stands in FrameView::problem; `name` is the frame's, for exceptions of other libraries.
FrameView viewOf(const cv::Mat& bgr, const cv::Mat& depth, const CameraIntrinsics& camera,
                 const RgbdOptions& options, const std::string& name);

/// The pyramid of a stored image: the very one that its view had.
Pyramid pyramidOf(const PackedImage& image);

/// The coarsest level of a view: how far away what it shows is.
struct CoarseView {
  CameraIntrinsics camera;
  cv::Mat depth;         ///< CV_32F [m]; NaN where there is none
  double meanDepth = 0;  ///< [m]
};
CoarseView coarseOf(const Pyramid& pyramid);

/// How far a motion of the camera moves what it sees, on average [m].
double shiftOfScene(const cv::Affine3d& motion, const CoarseView& seen);

/// Share of the source's points that lie on the target's surface at this T_target_source, within a tenth of
/// their depth. Looks at every `stride`-th row and column.
double predictedOverlap(const CoarseView& source, const CoarseView& target, const cv::Affine3d& motion,
                        int stride = 1);

}  // namespace estancia::odometry
