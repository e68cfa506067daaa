// SPDX-License-Identifier: Apache-2.0
#include "estancia/figures/plan_shapes.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace estancia::report {
namespace {

/// Pixels a side that a mask is traced in, at most.
constexpr int maxPixels = 1500;

/// Traces the part of `mask` (CV_8U) in `box`.
Outlines trace(const cv::Mat& mask, const cv::Rect& box, const FloorCells& cells) {
  const int longest = std::max(box.width, box.height);
  // Contours run through the middles of pixels: with three pixels a cell they keep near to its border.
  const double scale = longest * 3 <= maxPixels ? 3 : std::min(1.0, static_cast<double>(maxPixels) / longest);
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
