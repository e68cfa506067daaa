// SPDX-License-Identifier: Apache-2.0
#include "estancia/figures/driven_path.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace estancia::report {
namespace {

/// Traces the part of `mask` (CV_8U) in `box`, in 1500 pixels a side at most.
Outlines trace(const cv::Mat& mask, const cv::Rect& box, const FloorCells& cells) {
  const int longest = std::max(box.width, box.height);
  // Contours run through the middles of pixels: with three pixels a cell they keep near to its border.
  const double scale = longest * 3 <= 1500 ? 3 : std::min(1.0, 1500.0 / longest);
  cv::Mat pixels;
  cv::resize(mask, pixels, {}, scale, scale, scale < 1 ? cv::INTER_AREA : cv::INTER_NEAREST);
  pixels = pixels >= 64;
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(pixels, contours, cv::RETR_CCOMP, cv::CHAIN_APPROX_NONE);
  Outlines outlines;
  for (const std::vector<cv::Point>& contour : contours) {
    std::vector<cv::Point> corners;
    cv::approxPolyDP(contour, corners, 0.6 * std::max(scale, 1.0), true);
    if (corners.size() < 3) continue;
    outlines.emplace_back();
    const cv::Point first = cells.extent().tl() + box.tl();
    for (const cv::Point& corner : corners)
      outlines.back().push_back({cells.cell() * (first.x + (corner.x + 0.5) / scale),
                                 cells.cell() * (first.y + (corner.y + 0.5) / scale)});
  }
  return outlines;
}

/// The box of each area's cells, in one pass.
std::vector<cv::Rect> boxesOf(const AreaPlan& plan) {
  std::vector<cv::Rect> boxes(plan.areas.size());
  for (int row = 0; row < plan.areaOf.rows; ++row)
    for (int column = 0; column < plan.areaOf.cols; ++column) {
      const int area = plan.areaOf.at<int>(row, column);
      if (area < 0 || area >= static_cast<int>(boxes.size())) continue;
      boxes[static_cast<std::size_t>(area)] |= cv::Rect(column, row, 1, 1);
    }
  return boxes;
}

}  // namespace

Markup openFigure(const char* kind, const FigureStyle& style, const std::string& label) {
  Markup svg;
  svg.open("svg", {{"class", fmt::format("{} {}", kind, style.name)},
                   {"viewBox", fmt::format("0 0 {} {}", number(style.width), number(style.height))},
                   {"role", "group"},
                   {"aria-label", label}});
  return svg;
}

double neededHeight(const Fit& fit, const std::vector<Point>& extent, const FigureStyle& style,
                    double borders) {
  Extent drawn{fit.to, fit.to};
  for (const Point& p : extent) drawn.add(fit(p));
  return std::clamp(std::ceil(drawn.high.y - drawn.low.y + borders), 0.55 * style.width, style.height);
}

void drawPath(Markup& svg, const std::vector<std::optional<Point>>& points, const Fit& fit,
              std::span<const std::size_t> starts) {
  constexpr double step = 1.5;
  Path path;
  std::optional<Point> last;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i] || std::ranges::binary_search(starts, i)) last.reset();
    if (!points[i]) continue;
    const Point p = fit(*points[i]);
    if (last && std::hypot(p.x - last->x, p.y - last->y) < step) continue;
    last ? path.line(p.x, p.y) : path.move(p.x, p.y);
    last = p;
  }
  if (!path.empty()) svg.leaf("path", {{"class", "driven"}, {"d", path.str()}});
}

Box drawScale(Markup& svg, double scale, const FigureStyle& style) {
  if (!(scale > 0)) return {};
  const double most = 0.2 * style.width / scale;
  const double power = std::pow(10, std::floor(std::log10(most)));
  const double meters = 5 * power <= most ? 5 * power : 2 * power <= most ? 2 * power : power;
  const double x = figureMargin, y = style.height - figureMargin, length = meters * scale;
  svg.leaf("path",
           {{"class", "scale"},
            {"d", Path().move(x, y - 5).line(x, y).line(x + length, y).line(x + length, y - 5).str()}});
  addText(svg, "scale-text", {x + 6, y - 6}, style.fontSize, significant(meters) + " m");
  return {x, y - 8 - style.fontSize, std::max(length, 50.0), 8 + style.fontSize};
}

PlanShapes shapesOf(const AreaPlan& plan) {
  PlanShapes shapes;
  const std::vector<cv::Rect> boxes = boxesOf(plan);
  for (std::size_t i = 0; i < boxes.size(); ++i)
    shapes.areas.push_back(boxes[i].empty()
                               ? Outlines()
                               : trace(plan.areaOf(boxes[i]) == static_cast<int>(i), boxes[i], plan.cells));
  const cv::Rect walls = cv::boundingRect(plan.walls);
  if (!walls.empty()) shapes.walls = trace(plan.walls(walls), walls, plan.cells);
  return shapes;
}

std::string pathOf(const Outlines& outlines, const Fit& fit) {
  Path path;
  for (const std::vector<Point>& outline : outlines) {
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const Point at = fit(outline[i]);
      i == 0 ? path.move(at.x, at.y) : path.line(at.x, at.y);
    }
    path.close();
  }
  return path.str();
}

}  // namespace estancia::report
