// Parts of every metric drawing: its size, the floor plan as its ground, the driven path as a line, a scale.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estancia/areas/area_plan.hpp"
#include "estancia/figures/floor_plan.hpp"
#include "estancia/figures/layout.hpp"

namespace estancia::report {

struct FigureStyle {
  double width = 780, height = 580;  ///< CSS pixels; the height is the most there may be
  double fontSize = 12;
  bool words = true;  ///< words beside names, where there is room for both
  std::string name;   ///< class of the <svg>
};

constexpr double figureMargin = 14;  ///< [CSS pixels]

/// Opens the <svg> of a figure: of class `kind` and the style's name, read out as `label`.
Markup openFigure(const char* kind, const FigureStyle& style, const std::string& label);

/// Height that the drawing needs at this scale, within reason: a flat map leaves no empty card.
double neededHeight(const Fit& fit, const std::vector<Point>& extent, const FigureStyle& style,
                    double borders);

/// A dotted line, thinned to steps one can see; it breaks where no point is known, and at the `starts` of
/// drives.
void drawPath(Markup& svg, const std::vector<std::optional<Point>>& points, const Fit& fit,
              std::span<const std::size_t> starts = {});

/// A bar of 1, 2 or 5 · 10ⁿ meters, at most a fifth of the width, at the foot of the figure; `scale` is in
/// pixels a meter, and nothing is drawn where it is 0. Returns what is covered.
Box drawScale(Markup& svg, double scale, const FigureStyle& style);

/// Draws the image, or floors, walls, doors as gaps in them, windows as double lines, and the names of rooms
/// in letters of `nameSize` pixels (0: none).
void drawFloorPlan(Markup& svg, const FloorPlan& plan, const Fit& fit, double nameSize);

/// The corners of the plan [m], which a drawing has to have room for.
std::vector<Point> cornersOf(const FloorPlan& plan);

/// Throws Error where the frames cannot be drawn on it: none has a position (insufficientData), or fewer than
/// half of those that have one lie in rooms (mismatch), as when the trajectory has another origin.
void requireFitting(const FloorPlan& plan, const std::vector<std::optional<Point>>& frames);

/// Closed lines in the floor's axes [m]: what an odd number of them surrounds is inside.
using Outlines = std::vector<std::vector<Point>>;

struct PlanShapes {
  /// The free floor of each area, in the order of AreaPlan::areas.
  std::vector<Outlines> areas;
  Outlines walls;
};

/// Traces the cells of a plan, to half a cell; a plan of more than 1500 cells a side more coarsely.
PlanShapes shapesOf(const AreaPlan& plan);

/// Path of a figure, for fill-rule evenodd.
std::string pathOf(const Outlines& outlines, const Fit& fit);

}  // namespace estancia::report
