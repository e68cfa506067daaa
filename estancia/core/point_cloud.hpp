// Point cloud: points with colors and normals, organized as an image or not.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "estancia/core/camera.hpp"
#include "estancia/core/pose.hpp"

namespace estancia {

/// Points [m]. Invariant: width × height points, row by row; `colors` (BGR) and `normals` are empty or have
/// one a point.
struct PointCloud {
  /// NaN where an organized cloud has a hole.
  std::vector<cv::Point3f> points;
  /// BGR.
  std::vector<cv::Vec3b> colors;
  /// Unit vectors towards the viewpoint; NaN where unknown.
  std::vector<cv::Point3f> normals;
  /// Size of the image behind an organized cloud; an unorganized one has height 1.
  std::size_t width = 0, height = 0;
  /// Pose of the sensor in the frame of the points; none: at the origin.
  std::optional<Pose> viewpoint = {};

  bool organized() const { return height > 1; }
};

/// Throws Error (invalidInput) on a cloud that breaks the invariant of PointCloud.
void validate(const PointCloud& cloud);

/// A vector from a file or a user, scaled to unit length unless it has it; NaN without direction.
cv::Point3f asNormal(const cv::Point3f& vector);

inline bool isFinite(const cv::Point3f& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

/// Whether a sensor measured a point: many drivers write 0, 0, 0, where the sensor itself is, for pixels
/// without depth.
inline bool isMeasured(const cv::Point3f& p) {
  return isFinite(p) && p != cv::Point3f();
}

/// Throws Error (invalidInput) on a depth image that is empty or of another type than CV_32F, and on a camera
/// without a size or focal length.
void requireDepth(const cv::Mat& depth, const CameraIntrinsics& camera);

/// The organized cloud of a depth image (CV_32F, meters), in the optical frame of `camera`, whose images may
/// have another size. Pixels without a positive, finite depth become holes. Throws Error as requireDepth().
PointCloud backProject(const cv::Mat& depth, const CameraIntrinsics& camera);

/// These points of the cloud with their colors and normals, not organized. Throws Error (invalidInput) on an
/// index beyond the cloud.
PointCloud pointsOf(const PointCloud& cloud, const std::vector<std::uint32_t>& points);

/// The finite points of the cloud with their colors and normals, not organized.
PointCloud finitePoints(const PointCloud& cloud);

}  // namespace estancia
