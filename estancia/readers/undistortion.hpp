// Undistortion: images of a calibrated camera, fisheye or not, as those of a pinhole camera, also of another
// one. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/affine.hpp>
#include <opencv2/core/mat.hpp>

#include "estancia/core/camera.hpp"
#include "estancia/ros/messages.hpp"

namespace estancia::io {

/// The calibration of a CameraInfo, and the maps computed from it. Copies share them; thread-safe.
class Undistortion {
 public:
  /// `isRectified`: the images have been undistorted already, the projection matrix is theirs. Throws Error:
  /// invalidInput for a camera that is not calibrated (a focal length of 0) or whose numbers are none;
  /// unsupportedFile for a distortion model that is not read.
  Undistortion(const ros::CameraInfo& info, bool isRectified);

  /// Camera of the output images, in the size of the calibration. Without distortion it equals the camera
  /// matrix. With it a camera that sees, along both axes, no more than the original one does, and at most
  /// 100°: a pinhole image of a wider view is mostly stretched border.
  const CameraIntrinsics& camera() const { return camera_; }
  /// Whether anything changes.
  bool isNeeded() const { return !mapX_.empty(); }
  /// An image of the calibration's size, or of the same view in another size; black where nothing was seen.
  cv::Mat image(const cv::Mat& image) const;
  /// Depth (CV_32F): that of the nearest pixel, so that edges are not smeared; 0 where nothing was seen.
  cv::Mat depth(const cv::Mat& depth) const;

 private:
  cv::Mat mapped(const cv::Mat& image, int interpolation) const;

  CameraIntrinsics camera_;
  cv::Mat mapX_, mapY_;
};

/// Registered depth: `depth` (CV_32F [m], 0 where unknown) of the camera `from`, whose images may have
/// another size, as `to` would see it at T_to_from; in the size of `depth`, so that hardly a pixel stays
/// empty between two. The nearer of two things wins.
cv::Mat registerDepth(const cv::Mat& depth, const CameraIntrinsics& from, const cv::Affine3d& toFromFrom,
                      const CameraIntrinsics& to);

}  // namespace estancia::io
