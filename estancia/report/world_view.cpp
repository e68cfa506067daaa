// SPDX-License-Identifier: Apache-2.0
#include "estancia/report/world_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "estancia/world_query/world_json.hpp"

namespace estancia::report {

Point onFloor(const Floor& floor, const cv::Vec3d& at) {
  const cv::Point2d point = floor.position(at);
  return {point.x, point.y};
}

std::vector<Point> boxOnFloor(const WorldObject& object, const Floor& floor) {
  for (const double value : {object.center.x, object.center.y, object.center.z, object.size.x, object.size.y})
    if (!(std::abs(value) < 1e6)) return {};  // [m]
  const Point center = onFloor(floor, object.center);
  const double c = std::cos(object.yaw), s = std::sin(object.yaw);
  const double x = object.size.x / 2, y = object.size.y / 2;
  std::vector<Point> corners;
  for (const Point& corner : {Point{-x, -y}, Point{x, -y}, Point{x, y}, Point{-x, y}})
    corners.push_back({center.x + c * corner.x - s * corner.y, center.y + s * corner.x + c * corner.y});
  return corners;
}

namespace {

/// The images of what was seen most often first, as many as there is room for.
void loadObjectImages(const WorldPage& page, WorldView& view) {
  if (!page.image) return;
  std::vector<const WorldObject*> order;
  for (const WorldObject& object : page.world.objects) order.push_back(&object);
  std::ranges::stable_sort(order, [](auto* a, auto* b) { return a->views > b->views; });
  std::size_t left = page.bytes;
  for (const WorldObject* object : order) {
    const std::vector<unsigned char> bytes = page.image(object->id);
    if (bytes.empty()) continue;
    if (bytes.size() > left) {
      ++view.withheld;
      continue;
    }
    left -= bytes.size();
    view.images.emplace(object->id, imageUri(bytes, fmt::format("the image of object {}", object->id)));
  }
}

}  // namespace

Point WorldView::centerOf(const WorldObject& object) const {
  return onFloor(floor, object.center);
}

std::optional<Point> WorldView::start() const {
  for (const std::optional<WorldRoute>& route : routes)
    if (route && route->driven)
      return Point{route->driven->points.front().x, route->driven->points.front().y};
  return std::nullopt;
}

bool hasLayers(const WorldMap& world) {
  return world.plan.has_value() || !world.objects.empty();
}

WorldView viewOf(const WorldPage& page) {
  const WorldMap& world = page.world;
  WorldView view{world, floorOf(world)};
  for (const Drive& drive : world.places.drives) view.driveStarts.push_back(drive.firstFrame);
  for (const MappedFrame& frame : world.places.frames) {
    view.path.emplace_back();
    if (frame.pose && frame.pose->isPlausible())
      view.path.back() = onFloor(view.floor, {frame.pose->x, frame.pose->y, frame.pose->z});
  }
  for (const WorldObject& object : world.objects) view.boxes.push_back(boxOnFloor(object, view.floor));
  loadObjectImages(page, view);
  view.routes.resize(world.objects.size());
  view.areaRoutes.resize(world.areas.size());
  if (world.places.nodes.empty()) return view;
  view.from = page.from.value_or(world.places.frames.empty() ? world.places.nodes.front().id
                                                             : world.places.frames.front().node);
  view.routes = routesToObjects(world, view.from);
  view.areaRoutes = routesToEachArea(world, view.from);
  return view;
}

Color areaColor(int area) {
  constexpr std::size_t hues = 7, tones = 3;
  const auto number = static_cast<std::size_t>(area);
  const std::size_t round = number / hues;
  // Other hues first in each round, and the darker tone: areas of near numbers are often neighbors.
  return classStyle((number + 3 * round) % hues + distinctClasses / tones * (2 * round % tones)).fill;
}

Markup imageSymbols(const WorldView& view) {
  Markup svg;
  svg.open("svg", {{"class", "symbols"}, {"aria-hidden", "true"}});
  for (const auto& [object, uri] : view.images) {
    svg.open("symbol", {{"id", fmt::format("image-{}", object)}, {"viewBox", "0 0 1 1"}});
    svg.leaf("image",
             {{"width", 1}, {"height", 1}, {"preserveAspectRatio", "xMidYMid slice"}, {"href", uri}});
    svg.close();
  }
  return svg.close();
}

std::string probabilityText(const WorldObject& object) {
  if (!object.givenName.empty()) return "named by people";
  if (object.known) return fmt::format("recognized, {:.0f} %", 100 * object.known->confidence);
  return object.words.empty() ? "" : fmt::format("{:.0f} %", 100 * object.probability());
}

std::string whereText(const WorldObject& object, const WorldMap& world) {
  std::string where = supportText(object, world);
  if (const WorldArea* area = world.findArea(object.area))
    where += (where.empty() ? "in " : ", in ") + area->displayName();
  return where;
}

}  // namespace estancia::report
