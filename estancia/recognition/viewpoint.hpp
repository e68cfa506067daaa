// Viewpoint: clouds transformed into the frame of the sensor that recorded them.
#pragma once

#include <opencv2/core/affine.hpp>

#include "estancia/core/point_cloud.hpp"

namespace estancia {

/// T_view_cloud: into the frame of a camera at `viewpoint` [m] (x right, y down, z forward) that looks at the
/// centroid of the finite points; its roll is arbitrary. Throws Error (invalidOption) on a viewpoint that is
/// not finite, or the centroid itself.
cv::Affine3d viewFrom(const cv::Point3d& viewpoint, const PointCloud& cloud);

/// The cloud in another frame: points, normals, viewpoint.
PointCloud transformed(PointCloud cloud, const cv::Affine3d& transform);

}  // namespace estancia
