// Points that a depth camera or a scanner saw.
#pragma once

#include <cmath>
#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "estancia/core/camera.hpp"
#include "estancia/core/pose.hpp"

namespace estancia {

/// Points [m]. Invariant: width × height points, row by row; `colors` (BGR) and `normals` are empty or have
/// one a point.
struct PointCloud {
  std::vector<cv::Point3f> points;  ///< NaN where an organized cloud has a hole
  std::vector<cv::Vec3b> colors;
  std::vector<cv::Point3f> normals;    ///< unit vectors, towards whoever looked; NaN where none is known
  std::size_t width = 0, height = 0;   ///< of the image behind an organized cloud; else height is 1
  std::optional<Pose> viewpoint = {};  ///< where the sensor stood among the points; none: at the origin

  bool organized() const { return height > 1; }
};

/// Throws Error, naming what is off, on a cloud that breaks the invariant of PointCloud.
void requireWhole(const PointCloud& cloud);

/// A normal as a file or a user gives it, made to have unit length unless it has; NaN when it has no
/// direction.
cv::Point3f asNormal(const cv::Point3f& vector);

inline bool isFinite(const cv::Point3f& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

/// Throws Error on a depth image that has no pixel or another type than CV_32F, and on a camera without a
/// size or focal length.
void requireDepth(const cv::Mat& depth, const CameraIntrinsics& camera);

/// What a depth image (CV_32F, meters) saw, organized, in the optical frame of `camera`, whose images may
/// have another size. Pixels with 0, NaN or anything else that is no depth become holes. Throws Error as
/// requireDepth() does.
PointCloud backProject(const cv::Mat& depth, const CameraIntrinsics& camera);

}  // namespace estancia
