// Points that a depth camera or a scanner saw.
#pragma once

#include <cstddef>
#include <opencv2/core/types.hpp>
#include <vector>

namespace estancia {

/// Points [m]. Invariant: width × height points, row by row; `colours` (BGR) is empty or has one a point.
struct PointCloud {
  std::vector<cv::Point3f> points;  ///< NaN where an organised cloud has a hole
  std::vector<cv::Vec3b> colours;
  std::size_t width = 0, height = 0;  ///< of the picture behind an organised cloud; else height is 1

  bool organised() const { return height > 1; }
};

}  // namespace estancia
