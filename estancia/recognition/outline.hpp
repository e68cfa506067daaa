// Outlines: where a scene's surface ends, its planes, and where a model has no surface.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core/affine.hpp>
#include <vector>

#include "estancia/recognition/nearest_field.hpp"
#include "estancia/recognition/range_image.hpp"
#include "estancia/recognition/surface.hpp"

namespace estancia {

/// The lengths [m] by which a surface's outline is looked for.
struct OutlineScales {
  double step = 0;       ///< distance at which a surface goes on or ends; more than edges are rounded
  double tolerance = 0;  ///< distance from a plane within which a point lies in it
  double spacing = 0;    ///< spacing of the surface's points
};

/// How a scene's surface goes on around each of its points, and its large planes: found once a scene.
class Outline {
 public:
  enum State : std::int32_t {
    unknown = -2,  ///< hidden, or not measured
    ends = -1      ///< an edge, or a jump of depth
  };
  /// In eight directions of the tangent plane, a step away: the index of the point there if the surface goes
  /// on evenly, else a State.
  using Around = std::array<std::int32_t, 8>;

  struct Plane {
    cv::Point3f point, normal;
  };

  Outline() = default;
  Outline(const Surface& surface, const NearestField& field, const RangeImage& view,
          const OutlineScales& scales, int threads);

  bool empty() const { return around_.empty(); }
  double step() const { return static_cast<double>(step_); }  ///< [m]
  const Around& around(std::size_t point) const { return around_[point]; }
  /// The place a step away from a point of the surface in a direction [m].
  cv::Point3f place(const Surface& surface, std::size_t point, std::size_t direction) const;

  const std::vector<Plane>& planes() const { return planes_; }
  /// Index of the plane that a point lies in; -1: none.
  std::int32_t planeOf(std::size_t point) const { return planeOf_[point]; }

 private:
  void findPlanes(const Surface& surface, const OutlineScales& scales);

  float step_ = 0;
  std::vector<Around> around_;
  std::vector<Plane> planes_;
  std::vector<std::int32_t> planeOf_;
};

/// Where a model has a surface, and where it certainly has none.
struct ModelExtent {
  const Surface* surface = nullptr;
  const NearestField* field = nullptr;  ///< field of the surface
  /// A model of one side as its sensor saw it, and into that sensor's frame; null: all sides are known.
  const RangeImage* view = nullptr;
  cv::Affine3f toView = cv::Affine3f::Identity();
  float reach = 0;  ///< distance up to which a place is on the surface [m]

  /// Whether the model has no surface at a place of its frame [m], as far as its cloud shows.
  bool outside(const cv::Point3f& place) const;
};

}  // namespace estancia
