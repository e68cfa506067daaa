// Point cloud rendering: clouds drawn as an image that shows their shape.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core/affine.hpp>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <span>
#include <vector>

#include "estancia/core/point_cloud.hpp"

namespace estancia {

/// One cloud of an image.
struct CloudLayer {
  const PointCloud* cloud = nullptr;
  cv::Affine3d pose = cv::Affine3d::Identity();         ///< T_image_cloud
  std::optional<cv::Vec3b> color;                       ///< BGR; none: the cloud's own, or gray
  std::span<const std::array<std::uint32_t, 2>> edges;  ///< pairs of points that a line joins
};

/// Where one looks from: as the sensor did (at the origin, z forward, y down), or from beside.
struct CloudView {
  int width = 1280, height = 960;  ///< [pixels]
  double azimuth = 0;              ///< [deg] around the clouds, to the right
  double elevation = 0;            ///< [deg] upwards
};

/// The layers seen in perspective, as large as the image holds; the first decides where one stands. Shapes
/// show by shading distances (eye-dome lighting: Boucheny, thesis, Grenoble 2009). BGR, 8 bits. Points that
/// are not finite are left out. Throws Error when there is nothing to draw, or on a view without pixels.
cv::Mat drawClouds(std::span<const CloudLayer> layers, const CloudView& view = {});

}  // namespace estancia
