// SPDX-License-Identifier: Apache-2.0
#include "estancia/readers/depth_registration.hpp"

#include <cmath>
#include <opencv2/core.hpp>

#include "estancia/core/point_cloud.hpp"

namespace estancia::io {

cv::Mat registerDepth(const cv::Mat& depth, const CameraIntrinsics& from, const cv::Affine3d& toFromFrom,
                      const CameraIntrinsics& to) {
  requireDepth(depth, from);
  const CameraIntrinsics source = from.scaledTo(depth.cols, depth.rows),
                         target = to.scaledTo(depth.cols, depth.rows);
  const cv::Matx33d rotation = toFromFrom.rotation();
  const cv::Vec3d shift = toFromFrom.translation();
  cv::Mat registered = cv::Mat::zeros(depth.size(), CV_32F);
  for (int row = 0; row < depth.rows; ++row)
    for (int column = 0; column < depth.cols; ++column) {
      const double z = static_cast<double>(depth.at<float>(row, column));
      if (!(z > 0 && std::isfinite(z))) continue;
      const cv::Vec3d seen =
          rotation * cv::Vec3d(z * source.slopeX(column), z * source.slopeY(row), z) + shift;
      if (!(seen[2] > 0)) continue;
      const double u = std::round(target.fx * seen[0] / seen[2] + target.cx);
      const double v = std::round(target.fy * seen[1] / seen[2] + target.cy);
      if (!(u >= 0 && v >= 0 && u < depth.cols && v < depth.rows)) continue;
      float& nearest = registered.at<float>(static_cast<int>(v), static_cast<int>(u));
      if (nearest == 0 || seen[2] < static_cast<double>(nearest)) nearest = static_cast<float>(seen[2]);
    }
  return registered;
}

}  // namespace estancia::io
