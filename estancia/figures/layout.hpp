// Layout: where poses, nodes and labels are drawn: in the plane of the poses, else by the graph alone. All is
// deterministic. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/matx.hpp>
#include <optional>
#include <span>

#include "estancia/core/pose.hpp"
#include "estancia/figures/summary.hpp"
#include "estancia/figures/svg.hpp"

namespace estancia::report {

/// An orthonormal pair of axes that turns positions of the map [m] into the page's plane (x right, y up).
struct GroundPlane {
  cv::Vec3d right{1, 0, 0}, up{0, 1, 0};

  Point project(const cv::Vec3d& position) const;
};

/// The plane that shows a set of positions best. A map whose positions spread least along one of its axes is
/// seen along that axis and keeps its orientation: from above in z-up maps (x right, y up), and, in maps that
/// hang on a first camera (y down), with x right and z up. Otherwise the plane of largest spread (PCA).
GroundPlane planeOf(const std::vector<cv::Vec3d>& positions);

/// One point a pose in the map's plane [m], y up; none where the pose is unknown, not finite, or so far off
/// that it is an error of the trajectory.
struct DrivenPath {
  std::vector<std::optional<Point>> points;
  GroundPlane plane;
  bool empty = true;  ///< no pose is known
};
/// `fromAbove` uses x and y whatever their spread, as a floor plan needs it.
DrivenPath projectPath(std::span<const std::optional<Pose>> poses, bool fromAbove = false);

/// Positions of a graph's vertices without any knowledge but its edges, so that drawn distances follow the
/// number of edges between (Kamada & Kawai 1989). Unconnected parts are drawn side by side.
std::vector<Point> layoutGraph(std::size_t vertices, const std::vector<Link>& edges);

/// Turns, scales (one factor for both axes) and moves points into the middle of a box. `mayTurn` allows a
/// quarter turn that fits better. y grows downwards afterwards.
struct Fit {
  double scale = 1;  ///< page units a meter (or an edge); 0 where all points are one
  bool turned = false;
  Point from, to;  ///< center before and after

  Point operator()(const Point& p) const;
};
Fit fitInto(const std::vector<Point>& points, const Box& box, bool mayTurn);

/// Moves circles as little as possible until none overlap (with `gap` between) and all are in the box, as far
/// as there is room for them. Equal points part in a fixed pattern.
void separate(std::vector<Point>& centers, const std::vector<double>& radii, double gap, const Box& box);

/// The nodes of a map in the plane, in meters (y up) where poses are known, else in edges.
struct MapLayout {
  std::vector<Point> nodes;                   ///< one a node of the summary, all finite
  std::vector<std::optional<Point>> frames;   ///< the driven path, one a frame; empty without poses
  std::vector<std::size_t> driveStarts = {};  ///< frames before which the robot may have been carried
  bool metric = false;                        ///< positions come from poses
};
/// `fromAbove` uses x and y whatever their spread, as a floor plan needs it.
MapLayout layoutMap(const MapSummary& summary, bool fromAbove);

/// Where a label stands beside its point, and the side its text is written from.
struct LabelPlace {
  Box box;
  double x = 0;        ///< position of the text's anchor
  std::string anchor;  ///< "start", "middle", "end"
};

/// Places for labels.
class LabelPlaces {
 public:
  /// Labels stand beside discs and stay in a frame of this size; few cross the lines (pairs of discs). What
  /// is handed in must outlive this object.
  LabelPlaces(double width, double height, const std::vector<Point>& centers,
              const std::vector<double>& radii, std::vector<std::pair<std::size_t, std::size_t>> lines = {});

  /// The best of eight places round a disc for a label of this size, touching no disc and no other label, and
  /// as few lines as can be; nothing when there is none. It stays in the frame in a wider font, too.
  std::optional<LabelPlace> take(std::size_t disc, double width, double height);

  void block(const Box& box) { taken_.push_back(box); }

 private:
  bool isInside(const LabelPlace& place) const;
  bool isFree(const Box& box) const;

  Box frame_;
  const std::vector<Point>& centers_;
  const std::vector<double>& radii_;
  std::vector<std::pair<std::size_t, std::size_t>> lines_;
  std::vector<Box> taken_;
};

/// Places for images.
class Thumbnails {
 public:
  /// Images stay in `frame`; `size`: their width and height [CSS pixels].
  Thumbnails(const Box& frame, double size) : frame_(frame), size_(size) {}

  /// Nothing may cover this.
  void block(const Box& box) { taken_.push_back(box); }
  /// A square at the point, else beside it, else a smaller one there; nothing where there is no room.
  std::optional<Box> take(const Point& at);

 private:
  bool isFree(const Box& box) const;

  Box frame_;
  double size_;
  std::vector<Box> taken_;
};

}  // namespace estancia::report
