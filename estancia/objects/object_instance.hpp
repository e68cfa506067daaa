// Object instance: a thing in the map that several frames show.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <opencv2/core/types.hpp>
#include <utility>
#include <vector>

#include "estancia/core/oriented_box.hpp"

namespace estancia {

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
  /// What it stands on: the floor, another instance (by its number), or a surface that is no instance; or it
  /// hangs at a wall.
  enum class Stands { unknown, floor, instance, surface, wall } stands = Stands::unknown;
  int on = -1;
};

}  // namespace estancia
