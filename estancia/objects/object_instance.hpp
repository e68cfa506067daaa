// Object instance: a thing in the map that several frames show, by the segments in their segment images.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "estancia/core/oriented_box.hpp"

namespace estancia {

/// Segment image, CV_8U: what each pixel of a view shows. 0: no segment; 1 to maxSegments: its segment.
constexpr std::uint8_t maxSegments = 253;
/// An upright plane that passes for a wall, as does the front of a cabinet whose edges are not in view.
constexpr std::uint8_t wallPixel = 254;
/// On no plane of the room and in no segment: leaves, thin legs, crumbs.
constexpr std::uint8_t loosePixel = 255;

/// Whether the pixel is in a segment.
constexpr bool inSegment(std::uint8_t pixel) {
  return pixel > 0 && pixel <= maxSegments;
}

/// A segment of a frame, by the frame and its number in it.
using SegmentPlace = std::pair<std::size_t, std::size_t>;

struct ObjectInstance {
  /// On the floor's axes, z its height [m].
  OrientedBox box;
  /// The segments that show it, ascending.
  std::vector<SegmentPlace> segments;
  /// How many frames show it.
  std::size_t views = 0;
  /// Share of the frames seeing its place that show it as one object: lower end of the 95 % interval.
  double support = 0;
  /// It stands on the floor, another instance (its number), a surface that is none, or hangs at a wall.
  enum class Stands { unknown, floor, instance, surface, wall } stands = Stands::unknown;
  int on = -1;
};

}  // namespace estancia
