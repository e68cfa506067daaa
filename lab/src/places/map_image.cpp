// SPDX-License-Identifier: Apache-2.0
#include "places/map_image.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "estancia/core/image_codecs.hpp"
#include "estancia/core/png.hpp"
#include "estancia/figures/color.hpp"
#include "estancia/figures/driven_path.hpp"
#include "estancia/files/home_plan.hpp"

namespace estancia::experiments {
namespace {

using report::Point;

struct DrawnNode {
  Point at;
  std::string room;
  double frames = 0;
};

/// By id.
std::map<std::string, DrawnNode> drawnNodesOf(const CellResults& map, const report::GroundPlane& plane) {
  std::map<std::string, cv::Vec3d> positions;
  std::map<std::string, DrawnNode> nodes;
  for (const CellResult& result : map) {
    const std::string id = result.at.substr(0, result.at.find(' '));
    if (result.measure == "node_x") positions[id][0] = result.value;
    if (result.measure == "node_y") positions[id][1] = result.value;
    if (result.measure == "node_z") positions[id][2] = result.value;
    if (result.measure == "node_frames") nodes[id] = {{}, result.at.substr(id.size() + 1), result.value};
  }
  for (auto& [id, node] : nodes) node.at = plane.project(positions[id]);
  return nodes;
}

cv::Point pixelOf(const Point& point) {
  return {cvRound(point.x), cvRound(point.y)};
}

cv::Scalar bgrOf(const report::Color& color) {
  return {static_cast<double>(color.blue), static_cast<double>(color.green), static_cast<double>(color.red)};
}

const cv::Scalar wallColor(150, 150, 150), pathColor(205, 195, 185), ink(60, 50, 45);

void drawPlan(cv::Mat& image, const FloorPlan& plan, const report::Fit& fit) {
  if (plan.home) {
    for (const io::HomeRoom& room : plan.home->rooms) {
      std::vector<cv::Point> corners;
      for (const cv::Point2f& corner : room.polygon) corners.push_back(pixelOf(fit({corner.x, corner.y})));
      cv::polylines(image, corners, true, wallColor, 2, cv::LINE_AA);
    }
    return;
  }
  const cv::Point corner = pixelOf(fit({plan.xMin, plan.yMax})), other = pixelOf(fit({plan.xMax, plan.yMin}));
  const cv::Rect whole(corner, other), seen = whole & cv::Rect({0, 0}, image.size());
  cv::Mat drawing = imageCodecs().decode(plan.image, DecodedAs::color);
  if (drawing.empty() || drawing.depth() != CV_8U || seen.empty()) return;
  cv::resize(drawing, drawing, whole.size(), 0, 0, cv::INTER_AREA);
  cv::Mat under = image(seen);
  cv::addWeighted(drawing(seen - whole.tl()), 0.5, under, 0.5, 0, under);  // pale: the map is in front
}

void drawPath(cv::Mat& image, const std::vector<std::optional<Point>>& path, const report::Fit& fit) {
  for (std::size_t i = 1; i < path.size(); ++i)
    if (path[i - 1] && path[i])
      cv::line(image, pixelOf(fit(*path[i - 1])), pixelOf(fit(*path[i])), pathColor, 2, cv::LINE_AA);
}

/// Large ones first, small ones on top; in a wide image each room is named at its largest.
void drawNodes(cv::Mat& image, const std::map<std::string, DrawnNode>& nodes,
               const std::vector<std::string>& rooms, const report::Fit& fit, bool isWide) {
  std::vector<const DrawnNode*> order;
  for (const auto& [id, node] : nodes) order.push_back(&node);
  std::ranges::stable_sort(order, std::ranges::greater{}, [](const DrawnNode* n) { return n->frames; });
  std::map<std::string, cv::Point> named;
  for (const DrawnNode* node : order) {
    const auto room = std::ranges::find(rooms, node->room);
    const auto style = room == rooms.end()
                           ? report::plainStyle()
                           : report::classStyle(static_cast<std::size_t>(room - rooms.begin()));
    const int radius =
        cvRound((4 + 9 * std::sqrt(node->frames / order.front()->frames)) * (isWide ? 1 : 0.6));
    const cv::Point at = pixelOf(fit(node->at));
    cv::circle(image, at, radius, bgrOf(style.fill), cv::FILLED, cv::LINE_AA);
    cv::circle(image, at, radius, ink, 1, cv::LINE_AA);
    if (isWide && !node->room.empty()) named.emplace(node->room, at + cv::Point(radius + 2, 4));
  }
  for (const auto& [room, at] : named)
    for (const bool isHalo : {true, false})
      cv::putText(image, room.substr(0, 14), at, cv::FONT_HERSHEY_SIMPLEX, 0.4,
                  isHalo ? cv::Scalar::all(255) : ink, isHalo ? 3 : 1, cv::LINE_AA);
}

}  // namespace

std::vector<unsigned char> drawMap(const CellResults& map, const MapGround& ground, bool isWide) {
  const auto nodes = drawnNodesOf(map, ground.path.plane);
  if (nodes.empty() || ground.path.empty) return {};
  std::vector<Point> shown;
  for (const auto& point : ground.path.points)
    if (point) shown.push_back(*point);
  if (ground.floorPlan)
    for (const Point& corner : report::cornersOf(*ground.floorPlan)) shown.push_back(corner);
  report::Extent extent;
  for (const Point& point : shown) extent.add(point);
  const double width = isWide ? 480 : 240, margin = isWide ? 26 : 12;
  const double wide = extent.high.x - extent.low.x, high = extent.high.y - extent.low.y;
  const double needed = wide > 0 ? (width - 2 * margin) * high / wide : width;
  const double height = std::clamp(needed + 2 * margin, width / 3, width);
  const report::Fit fit =
      report::fitInto(shown, {margin, margin, width - 2 * margin, height - 2 * margin}, /*mayTurn=*/false);

  cv::Mat image(cvRound(height), cvRound(width), CV_8UC3, cv::Scalar::all(255));
  if (ground.floorPlan) drawPlan(image, *ground.floorPlan, fit);
  drawPath(image, ground.path.points, fit);
  for (const CellResult& result : map) {
    if (result.measure != "link") continue;
    const auto gap = result.at.find(' ');
    const auto a = nodes.find(result.at.substr(0, gap)), b = nodes.find(result.at.substr(gap + 1));
    if (a != nodes.end() && b != nodes.end())
      cv::line(image, pixelOf(fit(a->second.at)), pixelOf(fit(b->second.at)), ink, isWide ? 2 : 1,
               cv::LINE_AA);
  }
  drawNodes(image, nodes, ground.rooms, fit, isWide);
  return toPng(image);
}

}  // namespace estancia::experiments
