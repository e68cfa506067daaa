// Frame view: one RGB-D image, ready to be aligned with others by its pyramid or by its features.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/affine.hpp>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "estancia/core/bytes.hpp"
#include "estancia/core/camera.hpp"
#include "estancia/odometry/pyramid.hpp"
#include "estancia/odometry/rgbd.hpp"

namespace estancia::odometry {

/// Corners of an image that have depth.
struct Features {
  CameraIntrinsics camera;  ///< camera of the image
  std::vector<cv::Point2f> pixels;
  std::vector<cv::Point3f> points;  ///< in the camera's frame [m]
  cv::Mat descriptors;              ///< a row each (ORB, Rublee et al. 2011)
};

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

/// T_target_source from features that are matched both ways and agree on one motion (RANSAC with a fixed
/// seed); nothing when fewer than `minInliers` agree.
std::optional<cv::Affine3d> guessFromFeatures(const Features& source, const Features& target, int minInliers);

void write(const Features& features, ByteWriter& bytes);
/// Throws Error (malformedFile).
Features readFeatures(ByteReader& bytes);

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
