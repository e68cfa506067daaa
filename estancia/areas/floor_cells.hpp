// Floor cells: a grid over the floor that grows with what is seen.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

namespace estancia {

/// Which cell of an image holds which point of the floor. The image grows by whole cells; what was drawn in
/// it keeps its place on the floor.
class FloorCells {
 public:
  /// `cell`: the width of a cell [m], > 0.
  explicit FloorCells(double cell) : cell_(cell) {}
  /// `extent`: the first column and row, counted in cells from the floor's origin, and how many there are.
  FloorCells(double cell, const cv::Rect& extent) : cell_(cell), extent_(extent) {}

  const cv::Rect& extent() const { return extent_; }

  double cell() const { return cell_; }
  int rows() const { return extent_.height; }
  int columns() const { return extent_.width; }
  bool empty() const { return extent_.empty(); }

  /// The cell that holds the point (x, y) [m], as column and row; it may lie outside.
  cv::Point at(double x, double y) const;
  bool holds(cv::Point cell) const { return cv::Rect(0, 0, columns(), rows()).contains(cell); }
  /// The middle of a cell [m].
  cv::Point2d centerOf(cv::Point cell) const;

  /// Grows so that all points within `radius` of (x, y) [m] are inside. Returns how many cells came before
  /// the first column, before the first row, behind the last column and behind the last row. Throws Error
  /// (tooLarge) when there would be more cells than fit into memory: then nothing has changed.
  cv::Vec4i cover(double x, double y, double radius);

 private:
  double cell_;
  cv::Rect extent_;  // in cells from the floor's origin
};

/// `image` with a border of so many empty cells; see FloorCells::cover().
cv::Mat grown(const cv::Mat& image, const cv::Vec4i& border);

}  // namespace estancia
