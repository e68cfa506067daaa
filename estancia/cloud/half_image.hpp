// Half-resolution depth: every second pixel with its normal, in which planes are searched for.
#pragma once

#include <cstddef>
#include <vector>

#include "estancia/cloud/inverse_depth.hpp"

namespace estancia {

/// Every second pixel of every second row of an InverseDepth, with its normal.
struct HalfImage {
  int width, height;
  double pixelArea;               ///< of a surface at 1 m that faces the camera [m²]
  std::vector<float> x, y;        ///< slopes of the columns and rows
  std::vector<float> w;           ///< 1/z, 0: none
  std::vector<float> nx, ny, nz;  ///< unit vectors away from the camera; 0 where there is no normal
  std::vector<float> near;        ///< tolerance of w beside a plane a x + b y + c, divided by |(a, b, c)|
  std::size_t row(int v) const { return static_cast<std::size_t>(v) * static_cast<std::size_t>(width); }
};

/// `tolerance` [m at 1 m] is the distance within which a pixel lies on a plane.
HalfImage halve(const InverseDepth& grid, double tolerance, int threads);

}  // namespace estancia
