// Depth reprojection: how well two depth images agree under a given camera motion.
#pragma once

#include <opencv2/core/affine.hpp>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "estancia/core/camera.hpp"

namespace estancia::check {

/// A depth image reduced to some thousand points.
class DepthView {
 public:
  /// `depth` in meters (CV_32F, 0 = none); `camera` of any size.
  DepthView(const cv::Mat& depth, const CameraIntrinsics& camera);

  const std::vector<cv::Vec3d>& points() const { return points_; }  ///< in the optical frame [m]

  /// The depth in the direction of the point `p` [m]; 0 when it is out of view or has no depth.
  double depthTowards(const cv::Vec3d& p) const;

 private:
  cv::Mat depth_;  ///< small, CV_32F
  CameraIntrinsics camera_;
  std::vector<cv::Vec3d> points_;
};

/// The share in [0, 1] of the points of both views that have the same depth (within 4 %) in the other view,
/// after transformation by `bFromA` (T_b_a). Points out of the other's view do not match.
double reprojectionMatch(const DepthView& a, const DepthView& b, const cv::Affine3d& bFromA);

}  // namespace estancia::check
