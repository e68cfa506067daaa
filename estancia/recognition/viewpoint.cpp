#include "estancia/recognition/viewpoint.hpp"

#include <fmt/format.h>

#include <cmath>

#include "estancia/core/error.hpp"
#include "estancia/core/rigid.hpp"

namespace estancia {

cv::Affine3d viewFrom(const cv::Point3d& viewpoint, const PointCloud& cloud) {
  if (!std::isfinite(viewpoint.x) || !std::isfinite(viewpoint.y) || !std::isfinite(viewpoint.z))
    throw Error(ErrorCode::invalidOption,
                fmt::format("the viewpoint is ({}, {}, {}); give finite coordinates", viewpoint.x,
                            viewpoint.y, viewpoint.z));
  cv::Vec3d sum;
  double count = 0;
  for (const cv::Point3f& p : cloud.points) {
    if (!isFinite(p)) continue;
    sum += cv::Vec3d(p.x, p.y, p.z);
    ++count;
  }
  cv::Vec3d forward = count > 0 ? cv::Vec3d(sum * (1 / count) - cv::Vec3d(viewpoint)) : cv::Vec3d();
  const double away = cv::norm(forward);
  if (!(away > 0))
    throw Error(ErrorCode::invalidOption,
                fmt::format("the viewpoint ({}, {}, {}) is the center of the cloud; give that of the sensor",
                            viewpoint.x, viewpoint.y, viewpoint.z));
  forward *= 1 / away;
  const cv::Vec3d aside = std::abs(forward[1]) < 0.9 ? cv::Vec3d(0, 1, 0) : cv::Vec3d(1, 0, 0);
  cv::Vec3d right = aside.cross(forward);
  right *= 1 / cv::norm(right);
  const cv::Vec3d down = forward.cross(right);
  const cv::Matx33d turn(right[0], right[1], right[2], down[0], down[1], down[2], forward[0], forward[1],
                         forward[2]);
  return {turn, -(turn * cv::Vec3d(viewpoint))};
}

PointCloud transformed(PointCloud cloud, const cv::Affine3d& transform) {
  const cv::Matx33d turn = transform.rotation();
  for (cv::Point3f& p : cloud.points) p = transform * cv::Point3d(p);
  for (cv::Point3f& n : cloud.normals) n = turn * cv::Point3d(n);
  if (cloud.viewpoint) cloud.viewpoint = poseOf(transform * rigidOf(*cloud.viewpoint));
  return cloud;
}

}  // namespace estancia
