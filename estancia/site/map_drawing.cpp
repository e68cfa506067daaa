// SPDX-License-Identifier: Apache-2.0
#include "estancia/site/map_drawing.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "estancia/figures/layout.hpp"
#include "estancia/figures/plan_shapes.hpp"
#include "estancia/map_file/places.hpp"
#include "estancia/report/world_view.hpp"
#include "estancia/world_query/ask_world.hpp"
#include "estancia/world_query/world_json.hpp"

namespace estancia {
namespace {

using Json = nlohmann::ordered_json;
using report::Point;

/// To a centimeter.
Json drawnPoint(const Point& at) {
  return {std::round(at.x * 100) / 100, std::round(at.y * 100) / 100};
}

Json drawnLines(const report::Outlines& outlines) {
  Json json = Json::array();
  for (const std::vector<Point>& outline : outlines) {
    json.push_back(Json::array());
    for (const Point& point : outline) json.back().push_back(drawnPoint(point));
  }
  return json;
}

Point onFloor(const Floor& floor, const cv::Vec3d& at) {
  const cv::Point2d point = floor.position(at);
  return {point.x, point.y};
}

/// Where the robot drove: a line for each stretch with poses, without the points that a drawing does not
/// show, and of long drives every so many.
Json drawnPath(const WorldMap& world, const Floor& floor) {
  constexpr double step = 0.1;  // [m]
  constexpr std::size_t most = 4000;
  report::Outlines lines(1);
  const std::size_t stride = world.places.frames.size() / most + 1;
  for (std::size_t i = 0; i < world.places.frames.size(); i += stride) {
    const auto& pose = world.places.frames[i].pose;
    const bool isCarried = i > 0 && world.places.driveOf(i) != world.places.driveOf(i - stride);
    if (isCarried && !lines.back().empty()) lines.emplace_back();
    if (!pose || !pose->isPlausible()) {
      if (!lines.back().empty()) lines.emplace_back();
      continue;
    }
    const Point at = onFloor(floor, {pose->x, pose->y, pose->z});
    std::vector<Point>& line = lines.back();
    if (line.empty() || std::hypot(at.x - line.back().x, at.y - line.back().y) >= step) line.push_back(at);
  }
  std::erase_if(lines, [](const std::vector<Point>& line) { return line.size() < 2; });
  return drawnLines(lines);
}

/// Positions of nodes without poses, from the transitions alone.
std::vector<std::optional<Point>> positionsByLinks(const TopologicalMap& map) {
  constexpr std::size_t most = 300;  // all pairs are moved apart: seconds beyond that
  std::vector<std::optional<Point>> positions(map.nodes.size());
  if (map.nodes.size() > most) return positions;
  std::vector<report::Link> links;
  for (const auto& [a, b] : linksOf(map)) links.push_back({a, b, 1, 1});
  const std::vector<Point> found = report::layoutGraph(map.nodes.size(), links);
  std::ranges::copy(found, positions.begin());
  return positions;
}

Json drawnAreas(const WorldMap& world, const report::PlanShapes& shapes) {
  Json json = Json::array();
  for (std::size_t i = 0; i < world.areas.size(); ++i) {
    json.push_back(toJson(world.areas[i]));
    json.back()["outlines"] = i < shapes.areas.size() ? drawnLines(shapes.areas[i]) : Json::array();
    json.back()["color"] = report::areaColor(world.areas[i].id).hex();
  }
  return json;
}

Json drawnObjects(const WorldMap& world, const Floor& floor) {
  const auto isNear = [](double value) { return std::abs(value) < 1e6; };  // [m] a damaged map has anything
  Json json = Json::array();
  for (const WorldObject& object : world.objects) {
    if (!isNear(object.center.x) || !isNear(object.center.y) || !isNear(object.center.z) ||
        !isNear(object.size.x) || !isNear(object.size.y))
      continue;
    const Point center = onFloor(floor, {object.center.x, object.center.y, object.center.z});
    const double c = std::cos(object.yaw), s = std::sin(object.yaw);
    const double x = object.size.x / 2, y = object.size.y / 2;
    Json box = Json::array();
    for (const Point& at : {Point{-x, -y}, Point{x, -y}, Point{x, y}, Point{-x, y}})
      box.push_back(drawnPoint({center.x + c * at.x - s * at.y, center.y + s * at.x + c * at.y}));
    json.push_back(toJson(object, world));
    json.back()["where"] = report::whereText(object, world);
    json.back()["node"] = world.places.frames.at(object.bestFrame).node;
    json.back()["color"] = report::Color{object.color[0], object.color[1], object.color[2]}.hex();
    json.back()["at"] = drawnPoint(center);
    json.back()["box"] = std::move(box);
  }
  return json;
}

}  // namespace

Json drawMap(const WorldMap& world, const Floor& floor, const std::vector<std::string>& placeNames) {
  const std::vector<Place> places = placesOf(world.places);
  const std::vector<int> areas = areasOfNodes(world);
  std::vector<std::optional<Point>> positions;
  for (const Place& place : places) {
    positions.emplace_back();
    if (const auto& at = place.position) positions.back() = onFloor(floor, {(*at)[0], (*at)[1], (*at)[2]});
  }
  const bool metric =
      world.plan || std::ranges::any_of(positions, [](const auto& p) { return p.has_value(); });
  if (!metric) positions = positionsByLinks(world.places);

  const report::PlanShapes shapes = world.plan ? report::shapesOf(*world.plan) : report::PlanShapes{};
  Json json{{"metric", metric},
            {"drives", world.places.drives.size()},
            {"areas", drawnAreas(world, shapes)},
            {"walls", drawnLines(shapes.walls)},
            {"path", metric ? drawnPath(world, floor) : Json::array()},
            {"places", Json::array()},
            {"links", Json::array()}};
  for (std::size_t i = 0; i < places.size(); ++i)
    json["places"].push_back({{"node", world.places.nodes[i].id},
                              {"name", placeNames[i].empty() ? Json(nullptr) : Json(placeNames[i])},
                              {"position", positions[i] ? drawnPoint(*positions[i]) : Json(nullptr)},
                              {"frames", world.places.nodes[i].frames},
                              {"area", areaReference(world, areas[i])}});
  for (const auto& [a, b] : linksOf(world.places))
    json["links"].push_back({world.places.nodes[a].id, world.places.nodes[b].id});
  json["objects"] = drawnObjects(world, floor);
  return json;
}

}  // namespace estancia
