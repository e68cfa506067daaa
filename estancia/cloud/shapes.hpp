// Some points that stand for each piece of a depth picture.
#pragma once

#include <cstdint>
#include <functional>
#include <opencv2/core/types.hpp>
#include <vector>

#include "estancia/cloud/inverse_depth.hpp"
#include "estancia/cloud/pieces.hpp"

namespace estancia {

struct Shape {
  std::uint32_t piece;
  std::vector<cv::Point3f> surface;  ///< spread over it, 1500 at most
  std::vector<cv::Point3f> border;   ///< along its border in the picture, 256 at most
  cv::Point3f low, high;             ///< of the border
  std::vector<float> x, y, z;        ///< the border by coordinate, so that many points are compared at once
};

/// Of all pieces that are not too small to tell, in their order.
std::vector<Shape> shapesOf(const InverseDepth& grid, const Mask& mask, const Pieces& pieces);

/// Joins each piece with what partners(its shape) names; asks on several threads.
void joinPartners(const std::vector<Shape>& shapes, const Mask& mask, int threads,
                  const std::function<std::vector<std::uint32_t>(const Shape&)>& partners, Pieces& pieces);

}  // namespace estancia
