// Rigid transforms: poses that can be multiplied and inverted.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <opencv2/core/affine.hpp>

#include "estancia/core/pose.hpp"

namespace estancia {

/// T_map_camera as a transform: its product with a point in the camera is that point in the map.
inline cv::Affine3d rigidOf(const Pose& p) {
  const double xx = p.qx * p.qx, yy = p.qy * p.qy, zz = p.qz * p.qz;
  const double xy = p.qx * p.qy, xz = p.qx * p.qz, yz = p.qy * p.qz;
  const double wx = p.qw * p.qx, wy = p.qw * p.qy, wz = p.qw * p.qz;
  return {cv::Matx33d(1 - 2 * (yy + zz), 2 * (xy - wz), 2 * (xz + wy),  //
                      2 * (xy + wz), 1 - 2 * (xx + zz), 2 * (yz - wx),  //
                      2 * (xz - wy), 2 * (yz + wx), 1 - 2 * (xx + yy)),
          cv::Vec3d(p.x, p.y, p.z)};
}

/// The inverse of rigidOf(); `transform` must be rigid.
inline Pose poseOf(const cv::Affine3d& transform) {
  const cv::Matx33d r = transform.rotation();
  const cv::Vec3d t = transform.translation();
  // Shepperd 1978: divide by the largest of the four, which is never near 0.
  const double trace = r(0, 0) + r(1, 1) + r(2, 2);
  const double squares[] = {1 + 2 * r(0, 0) - trace, 1 + 2 * r(1, 1) - trace, 1 + 2 * r(2, 2) - trace,
                            1 + trace};
  const auto i = static_cast<int>(std::max_element(squares, squares + 4) - squares);
  const int j = (i + 1) % 3, k = (i + 2) % 3;
  cv::Vec4d q;  // x y z w
  if (i == 3) {
    q = {r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1), squares[3]};
  } else {
    q[i] = squares[i];
    q[j] = r(j, i) + r(i, j);
    q[k] = r(k, i) + r(i, k);
    q[3] = r(k, j) - r(j, k);
  }
  q *= 1 / cv::norm(q);
  return {t[0], t[1], t[2], q[0], q[1], q[2], q[3]};
}

/// The rotation angle of a transform [rad, 0 to π].
inline double angleOf(const cv::Affine3d& transform) {
  const cv::Matx33d r = transform.rotation();
  const double sine = std::sqrt(std::pow(r(2, 1) - r(1, 2), 2) + std::pow(r(0, 2) - r(2, 0), 2) +
                                std::pow(r(1, 0) - r(0, 1), 2));
  return std::atan2(sine, r(0, 0) + r(1, 1) + r(2, 2) - 1);  // small angles, too, unlike the arc cosine
}

}  // namespace estancia
