// Feature matching: an initial pose of two distant views by ORB and PnP.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/affine.hpp>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "estancia/core/bytes.hpp"
#include "estancia/core/camera.hpp"

namespace estancia::odometry {

/// Corners of an image that have depth.
struct Features {
  CameraIntrinsics camera;  ///< camera of the image
  std::vector<cv::Point2f> pixels;
  std::vector<cv::Point3f> points;  ///< in the camera's frame [m]
  cv::Mat descriptors;              ///< a row each (ORB, Rublee et al. 2011)
};

/// At most `max` features with depth up to `maxDepth` [m]; `depth` [m, CV_32F] shows the same view in any
/// size, `camera` is scaled to both.
Features featuresOf(const cv::Mat& bgr, const cv::Mat& depth, const CameraIntrinsics& camera, int max,
                    double maxDepth);

/// T_target_source from features that are matched both ways and agree on one motion (RANSAC with a fixed
/// seed); nothing when fewer than `minInliers` agree.
std::optional<cv::Affine3d> guessFromFeatures(const Features& source, const Features& target, int minInliers);

void write(const Features& features, ByteWriter& bytes);
/// Throws Error (malformedFile).
Features readFeatures(ByteReader& bytes);

}  // namespace estancia::odometry
