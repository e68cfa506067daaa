// A map as shapes on the floor, for a page to draw.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "estancia/figures/driven_path.hpp"
#include "estancia/figures/layout.hpp"
#include "estancia/map_file/places.hpp"
#include "estancia/report/world_section.hpp"
#include "estancia/site/queries.hpp"
#include "estancia/world_query/ask_world.hpp"
#include "estancia/world_query/world_json.hpp"

namespace estancia {
namespace {

using Json = nlohmann::ordered_json;
using report::onFloor;
using report::Point;

/// To a centimeter.
Json drawnPoint(const Point& at) {
  return {std::round(at.x * 100) / 100, std::round(at.y * 100) / 100};
}

Json drawnLine(const std::vector<Point>& line) {
  Json json = Json::array();
  for (const Point& point : line) json.push_back(drawnPoint(point));
  return json;
}

Json drawnLines(const report::Outlines& outlines) {
  Json json = Json::array();
  for (const std::vector<Point>& outline : outlines) json.push_back(drawnLine(outline));
  return json;
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
  std::ranges::copy(report::layoutGraph(map.nodes.size(), links), positions.begin());
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
  Json json = Json::array();
  for (const WorldObject& object : world.objects) {
    const std::vector<Point> box = report::boxOnFloor(object, floor);
    if (box.empty()) continue;
    json.push_back(toJson(object, world));
    json.back()["where"] = report::whereText(object, world);
    json.back()["node"] = world.places.frames.at(object.bestFrame).node;
    json.back()["color"] = report::Color{object.color[0], object.color[1], object.color[2]}.hex();
    json.back()["at"] = drawnPoint(onFloor(floor, object.center));
    json.back()["box"] = drawnLine(box);
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
    if (const auto& at = place.position) positions.back() = onFloor(floor, cv::Vec3d(at->data()));
  }
  const bool metric = world.plan || std::ranges::any_of(positions, &std::optional<Point>::has_value);
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
