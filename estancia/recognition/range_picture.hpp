// What a sensor could see: how far it saw in each direction.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <opencv2/core/types.hpp>

namespace estancia {

/// The points of a scene as the sensor at the origin saw them, along +z (the optical frame). Cells hold the
/// nearest depth. Says nothing when the scene does not look like such a view: points behind the sensor, or a
/// wide angle.
class RangePicture {
 public:
  /// `spacing` [m]: how far apart points lie where the scene is.
  RangePicture(std::span<const cv::Point3f> points, double spacing);

  /// Depth [m] of the surface that the sensor saw in the direction of `place`; none where it saw nothing.
  std::optional<float> depth(const cv::Point3f& place) const;

  bool known() const { return !depths_.empty(); }

 private:
  std::vector<float> depths_;
  double left_ = 0, top_ = 0, cell_ = 0;  ///< slopes x / z, y / z
  int columns_ = 0, rows_ = 0;
};

}  // namespace estancia
