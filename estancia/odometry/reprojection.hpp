// Do two depth images agree on what is where, if the camera moved as somebody says?
#pragma once

#include <opencv2/core/affine.hpp>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "estancia/core/camera.hpp"

namespace estancia::odometry {

/// What a depth camera saw at one moment, reduced to some thousand points.
class DepthView {
 public:
  /// `depth` in meters (CV_32F, 0 = none); `camera` of any size.
  DepthView(const cv::Mat& depth, const CameraIntrinsics& camera);

  const std::vector<cv::Vec3d>& points() const { return points_; }  ///< in the optical frame [m]

  /// The depth [m] seen in the direction of the point `p`; 0 when it is out of view or has none.
  double depthTowards(const cv::Vec3d& p) const;

 private:
  cv::Mat depth_;  ///< small, CV_32F
  CameraIntrinsics camera_;
  std::vector<cv::Vec3d> points_;
};

/// The share in [0, 1] of the points of both views that the other one sees at the same depth (within 4 %),
/// once `bFromA` (T_b_a) has moved them. Points out of the other's view do not agree.
double agreement(const DepthView& a, const DepthView& b, const cv::Affine3d& bFromA);

}  // namespace estancia::odometry
