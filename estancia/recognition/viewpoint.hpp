// Scenes whose frame is not that of the sensor.
#pragma once

#include <opencv2/core/affine.hpp>

#include "estancia/core/point_cloud.hpp"

namespace estancia {

/// T_view_cloud: into the frame of a camera at `viewpoint` [m] (x right, y down, z forward) that looks at the
/// middle of the finite points. Which way is up does not matter to it. Throws Error on a viewpoint that is
/// not finite, or in the middle of the cloud.
cv::Affine3d viewFrom(const cv::Point3d& viewpoint, const PointCloud& cloud);

/// The cloud in another frame: points, normals, viewpoint.
PointCloud transformed(PointCloud cloud, const cv::Affine3d& transform);

}  // namespace estancia
