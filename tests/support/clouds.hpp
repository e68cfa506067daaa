// Point clouds of tests.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>
#include <vector>

#include "estancia/core/point_cloud.hpp"

namespace estancia::test {

/// Not organized, without normals.
inline PointCloud cloudOf(std::vector<cv::Point3f> points, std::vector<cv::Vec3b> colors = {}) {
  PointCloud cloud;
  cloud.colors = std::move(colors);
  cloud.points = std::move(points);
  cloud.width = cloud.points.size();
  cloud.height = 1;
  return cloud;
}

}  // namespace estancia::test
