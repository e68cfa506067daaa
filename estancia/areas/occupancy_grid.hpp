// Occupancy grid: what is free and what is wall in the floor plane, seen by a camera with depth.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>

#include "estancia/areas/area_plan.hpp"
#include "estancia/core/camera.hpp"
#include "estancia/core/pose.hpp"

namespace estancia {

/// Counts, for each cell of the floor, how often it was seen through and how often it ended a view.
///
/// Each column of a depth image gives one range: that of the farthest surface in it, since the camera sees
/// over chairs, tables and beds to the wall behind. The height and tilt of the camera need not be known. The
/// cells up to that range are free; the cell at the range is wall where the surface is upright.
class OccupancyGrid {
 public:
  /// `cell`: the width of a cell [m].
  OccupancyGrid(const Floor& floor, double cell) : floor_(floor), cells_(cell) {}
  /// With cells of its own: a plan may be made of it while views are added to the other.
  OccupancyGrid(const OccupancyGrid& other)
      : floor_(other.floor_), cells_(other.cells_), free_(other.free_.clone()), hits_(other.hits_.clone()) {}
  OccupancyGrid(OccupancyGrid&&) = default;
  OccupancyGrid& operator=(OccupancyGrid&&) = default;

  /// Adds a view: `depth` along the optical axis [m], CV_32F, 0 (or not finite) where unknown; the camera of
  /// that depth image, and where it stood. Throws Error (tooLarge) where the views span too many cells.
  void add(const cv::Mat& depth, const CameraIntrinsics& camera, const Pose& pose);

  const Floor& floor() const { return floor_; }
  const FloorCells& cells() const { return cells_; }

  /// 255 in each free cell (CV_8U, a row a step along the floor's second axis), seen through mostly; else 0.
  cv::Mat freeSpace() const;
  /// 255 in each cell that is wall.
  cv::Mat walls() const;

 private:
  bool isWall(int row, int column) const;

  Floor floor_;
  FloorCells cells_;
  cv::Mat free_, hits_;  // CV_32S, of the size of cells_
};

}  // namespace estancia
