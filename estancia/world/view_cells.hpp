// View cells: which views of a drive are kept, so that their number is bounded by the space, not by the time.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>

#include "estancia/core/pose.hpp"

namespace estancia {

/// Views are alike where they are from one cell of half a meter and look in about one direction (30°). The
/// first eight of a cell are kept, then one each time the drive has doubled: for a robot that repeats its
/// round the number of views of a cell grows with the logarithm of the days.
class ViewCells {
 public:
  bool wants(std::size_t frame, const Pose& pose) const {
    const auto cell = cells_.find(keyOf(pose));
    return cell == cells_.end() || cell->second.views < enough || frame >= 2 * cell->second.lastFrame;
  }
  void add(std::size_t frame, const Pose& pose) {
    Cell& cell = cells_[keyOf(pose)];
    ++cell.views;
    cell.lastFrame = frame;
  }

 private:
  static constexpr std::size_t enough = 8;
  static constexpr double width = 0.5;      // [m]
  static constexpr double direction = 0.5;  // edge of a cell of a direction's components: about 30°

  using Key = std::array<std::int64_t, 6>;
  struct Cell {
    std::size_t views = 0, lastFrame = 0;
  };

  /// `pose` is plausible.
  static Key keyOf(const Pose& pose) {
    const auto cellOf = [](double value, double size) {
      return static_cast<std::int64_t>(std::floor(value / size));
    };
    const std::array<double, 3> forward = pose.forward();
    // Middles of cells lie on the axes, so that a camera that looks along one stays in its cell.
    const auto turn = [&](double component) {  // in [-1, 1] also where the quaternion is none of unit length
      return cellOf(std::max(-1.0, std::min(1.0, component)) + direction / 2, direction);
    };
    return {cellOf(pose.x, width), cellOf(pose.y, width), cellOf(pose.z, width),
            turn(forward[0]),      turn(forward[1]),      turn(forward[2])};
  }

  std::map<Key, Cell> cells_;
};

}  // namespace estancia
