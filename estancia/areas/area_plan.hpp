// Area plan: the floor of a drive, split into areas that are named by what is seen in them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "estancia/core/pose.hpp"

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

/// A part of the floor that walls and doors enclose.
struct Area {
  /// Its position in AreaPlan::areas. Areas that the robot was in come first, by falling number of frames;
  /// but areas that were known before keep their numbers (keepNumbers()).
  int id = 0;
  /// The words that distinguish what is in it: "refrigerator, stove, microwave".
  std::string name = {};
  /// Free floor space [m²].
  double size = 0;
  /// The point of it that is farthest from its border, on the floor [m].
  cv::Point2d center = {};
  /// Its free space, counter-clockwise on the floor [m].
  std::vector<cv::Point2d> outline = {};
  /// How many frames were taken in it; 0 where the robot only looked in.
  std::size_t frames = 0;
};

struct AreaPlan {
  std::vector<Area> areas;
  /// The map's axes on the floor.
  Floor floor;
  FloorCells cells;
  /// CV_32S: the area of each cell, -1 where nothing is free.
  cv::Mat areaOf;
  /// CV_8U: 255 where walls are.
  cv::Mat walls;
};

/// A correction by a person. It is anchored to the floor [m], so that it outlives another segmentation.
struct AreaEdit {
  enum class Kind {
    /// The area at `from` is called `name`.
    name,
    /// The areas at `from` and `to` are one.
    merge,
    /// The area halfway between `from` and `to` is two, cut along the line between them, which goes on beyond
    /// each end to where the area ends. What is left of it is a new area.
    split
  };
  Kind kind = Kind::name;
  cv::Point2d from = {}, to = {};
  std::string name = {};
};

/// The area that a point of the floor lies in, else the nearest one within `reach` [m]; -1 where there is
/// none.
int areaAt(const AreaPlan& plan, const cv::Point2d& at, double reach);

/// The area that a thing is in, or stands at the edge of: within 2 m. `at`: in the map.
int areaOfObject(const AreaPlan& plan, const cv::Point3d& at);

}  // namespace estancia
