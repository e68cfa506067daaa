// Depth rendering: oriented points as discs, into the depth image of a camera.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/affine.hpp>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "estancia/core/camera.hpp"
#include "estancia/core/point_cloud.hpp"

namespace estancia::experiments {

/// A surface as discs that cover it.
struct Discs {
  std::vector<cv::Point3f> points, normals;
  double radius = 0;  // [m]
  cv::Vec3d center;
};

/// Uses the cloud's normals where it has them, and else those towards the origin. Throws Error (invalidInput)
/// on a cloud without points.
Discs discsOf(const PointCloud& cloud);

/// Depths [m] (CV_32F, 0 where there is nothing) where rays meet the discs, placed by T_camera_discs: at each
/// pixel the mean of those near the nearest.
cv::Mat rendered(const Discs& discs, const cv::Affine3d& pose, const CameraIntrinsics& camera);

/// T_camera_object of a camera that looks in a direction of the object's frame at `place` from `distance`
/// [m]; its image's up is the object's z.
cv::Affine3d lookingAt(const cv::Vec3d& place, const cv::Vec3d& forward, double distance);

}  // namespace estancia::experiments
