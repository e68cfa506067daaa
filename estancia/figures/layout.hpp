// Where to draw nodes: from their poses, else from the graph alone. Everything here is deterministic.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "estancia/figures/plane.hpp"
#include "estancia/figures/summary.hpp"
#include "estancia/figures/svg.hpp"

namespace estancia::report {

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

}  // namespace estancia::report
