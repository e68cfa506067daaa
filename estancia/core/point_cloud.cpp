// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/point_cloud.hpp"

#include <cmath>
#include <limits>
#include <opencv2/core.hpp>

#include "estancia/core/fail.hpp"

namespace estancia {

void validate(const PointCloud& cloud) {
  const std::size_t n = cloud.points.size();
  const bool shaped =
      n == 0 || (cloud.height > 0 && n / cloud.height == cloud.width && n % cloud.height == 0);
  if (shaped && (cloud.colors.empty() || cloud.colors.size() == n) &&
      (cloud.normals.empty() || cloud.normals.size() == n))
    return;
  fail(ErrorCode::invalidInput,
       "a cloud of {} × {} points has {} points, {} colors and {} normals; give all points one or none",
       cloud.width, cloud.height, n, cloud.colors.size(), cloud.normals.size());
}

cv::Point3f asNormal(const cv::Point3f& vector) {
  constexpr double unit = 1e-4;  // what is nearer to 1 stays as it is, bit by bit
  const double length = cv::norm(cv::Vec3d(vector.x, vector.y, vector.z));
  if (!(length > 0) || !std::isfinite(length)) {
    constexpr float none = std::numeric_limits<float>::quiet_NaN();
    return {none, none, none};
  }
  return std::abs(length - 1) < unit ? vector : cv::Point3f(cv::Point3d(vector) / length);
}

void requireDepth(const cv::Mat& depth, const CameraIntrinsics& camera) {
  if (depth.empty() || depth.type() != CV_32FC1)
    throw Error(ErrorCode::invalidInput,
                "a depth image must have one channel of 32-bit floats [m]; convert it");
  if (camera.width <= 0 || camera.height <= 0 || !(camera.fx > 0) || !(camera.fy > 0) ||
      !std::isfinite(camera.fx + camera.fy + camera.cx + camera.cy))
    fail(ErrorCode::invalidInput,
         "camera intrinsics {} x {} pixels, fx {}, fy {}, cx {}, cy {} are invalid; give positive sizes",
         camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy);
}

PointCloud backProject(const cv::Mat& depth, const CameraIntrinsics& camera) {
  requireDepth(depth, camera);
  const CameraIntrinsics own = camera.scaledTo(depth.cols, depth.rows);
  constexpr float hole = std::numeric_limits<float>::quiet_NaN();
  PointCloud cloud;
  cloud.width = static_cast<std::size_t>(depth.cols);
  cloud.height = static_cast<std::size_t>(depth.rows);
  cloud.points.reserve(cloud.width * cloud.height);
  for (int v = 0; v < depth.rows; ++v) {
    const auto* row = depth.ptr<float>(v);
    const auto y = static_cast<float>(own.slopeY(v));
    for (int u = 0; u < depth.cols; ++u) {
      const float z = row[u];
      if (z > 0 && std::isfinite(z))
        cloud.points.emplace_back(static_cast<float>(own.slopeX(u)) * z, y * z, z);
      else
        cloud.points.emplace_back(hole, hole, hole);
    }
  }
  return cloud;
}

PointCloud pointsOf(const PointCloud& cloud, const std::vector<std::uint32_t>& points) {
  validate(cloud);
  PointCloud part;
  part.width = points.size();
  part.height = 1;
  part.viewpoint = cloud.viewpoint;
  for (const std::uint32_t i : points) {
    if (i >= cloud.points.size())
      fail(ErrorCode::invalidInput,
           "the cloud has {} points, but point {} was requested; give indices of this cloud",
           cloud.points.size(), i);
    part.points.push_back(cloud.points[i]);
    if (!cloud.colors.empty()) part.colors.push_back(cloud.colors[i]);
    if (!cloud.normals.empty()) part.normals.push_back(cloud.normals[i]);
  }
  return part;
}

PointCloud finitePoints(const PointCloud& cloud) {
  std::vector<std::uint32_t> finite;
  for (std::size_t i = 0; i < cloud.points.size(); ++i)
    if (isFinite(cloud.points[i])) finite.push_back(static_cast<std::uint32_t>(i));
  return pointsOf(cloud, finite);
}

}  // namespace estancia
