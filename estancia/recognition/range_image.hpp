// Range image: the depth that the sensor measured in each direction, from an unorganized cloud.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <opencv2/core/types.hpp>

namespace estancia {

/// The points of a scene as seen by a sensor at the origin, along +z (the optical frame). Unknown when the
/// cloud is inconsistent with such a view: points behind the sensor, a wide angle, or two surfaces behind
/// each other all over, as of an object that was scanned from all sides.
class RangeImage {
 public:
  /// `spacing`: point spacing of the scene [m].
  RangeImage(std::span<const cv::Point3f> points, double spacing);

  /// Depth of the surface in the direction of `place` [m]; none where there is none.
  std::optional<float> depth(const cv::Point3f& place) const;

  /// Depths in that direction and in the cells around it.
  struct Depths {
    float nearest, farthest;  ///< [m]
  };
  std::optional<Depths> depthsAround(const cv::Point3f& place) const {
    const auto cell = cellOf(place);
    if (!cell || around_[*cell].farthest == 0) return {};
    return around_[*cell];
  }

  /// [m]; 0 when unknown.
  double medianDepth() const { return medianDepth_; }
  bool known() const { return !depths_.empty(); }
  /// Share of the directions in which a surface lies behind another; 1 for points that no such view contains.
  double hiddenShare() const { return hiddenShare_; }

 private:
  void spreadDepths(const std::vector<float>& farthest);
  std::optional<std::size_t> cellOf(const cv::Point3f& place) const {
    if (depths_.empty() || !(place.z > 0)) return {};
    const float c = (place.x / place.z - left_) * perCell_, r = (place.y / place.z - top_) * perCell_;
    if (!(c >= 0) || !(r >= 0) || c >= static_cast<float>(columns_) || r >= static_cast<float>(rows_))
      return {};
    return static_cast<std::size_t>(r) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(c);
  }

  double hiddenShare_ = 1, medianDepth_ = 0;
  std::vector<float> depths_;
  std::vector<Depths> around_;
  float left_ = 0, top_ = 0, perCell_ = 0;  ///< slopes x / z, y / z; cells per unit of slope
  int columns_ = 0, rows_ = 0;
};

}  // namespace estancia
