// SPDX-License-Identifier: Apache-2.0
#include "estancia/site/ros_publisher.hpp"

#include <spdlog/spdlog.h>

#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>

#include "estancia/core/error.hpp"
#include "estancia/map_file/places.hpp"

namespace estancia {
namespace {

using MarkerColor = ros::Marker::Color;

constexpr MarkerColor placeColor{0.2F, 0.5F, 0.9F, 1}, linkColor{0.5F, 0.5F, 0.5F, 0.8F},
    textColor{1, 1, 1, 1};
constexpr double placeSize = 0.2, linkWidth = 0.03, areaText = 0.4, objectTextHeight = 0.15;  // [m]

ros::Marker markerAt(const char* space, int id, ros::Marker::Type type, const Position& at, double size,
                     const MarkerColor& color) {
  ros::Marker marker;
  marker.space = space;
  marker.id = id;
  marker.type = type;
  marker.position = at;
  marker.scale = {size, size, size};
  marker.color = color;
  return marker;
}

ros::Marker textAt(const char* space, int id, Position at, double above, double height,
                   const std::string& text) {
  at[2] += above;
  ros::Marker marker = markerAt(space, id, ros::Marker::Type::text, at, height, textColor);
  marker.text = text;
  return marker;
}

void addPlaces(const TopologicalMap& map, std::vector<ros::Marker>& markers) {
  const std::vector<Place> places = placesOf(map);
  for (std::size_t i = 0; i < places.size(); ++i)
    if (places[i].position)
      markers.push_back(markerAt("places", map.nodes[i].id, ros::Marker::Type::sphere, *places[i].position,
                                 placeSize, placeColor));
  ros::Marker links = markerAt("transitions", 0, ros::Marker::Type::lineList, {}, linkWidth, linkColor);
  for (const auto& [from, to] : linksOf(map)) {
    if (!places[from].position || !places[to].position) continue;
    links.points.push_back(*places[from].position);
    links.points.push_back(*places[to].position);
  }
  if (!links.points.empty()) markers.push_back(links);
}

/// Above the frames that were taken in each.
void addAreas(const WorldMap& world, std::vector<ros::Marker>& markers) {
  std::vector<std::pair<Position, double>> sums(world.areas.size());  // positions, and how many
  for (std::size_t i = 0; i < world.areaOfFrame.size(); ++i) {
    const auto& pose = world.places.frames[i].pose;
    if (world.areaOfFrame[i] < 0 || !pose) continue;
    auto& [at, frames] = sums[static_cast<std::size_t>(world.areaOfFrame[i])];
    at = {at[0] + pose->x, at[1] + pose->y, at[2] + pose->z};
    ++frames;
  }
  for (const WorldArea& area : world.areas) {
    const auto& [at, frames] = sums[static_cast<std::size_t>(area.id)];
    if (frames > 0)
      markers.push_back(textAt("areas", area.id, {at[0] / frames, at[1] / frames, at[2] / frames}, 1,
                               areaText, area.displayName()));
  }
}

/// The box is upright in a map whose z is up.
void addObjects(const WorldMap& world, std::vector<ros::Marker>& markers) {
  for (const WorldObject& object : world.objects) {
    const Position at{object.center.x, object.center.y, object.center.z};
    const auto part = [&](std::size_t i) { return static_cast<float>(object.color[i]) / 255; };
    ros::Marker box =
        markerAt("objects", object.id, ros::Marker::Type::cube, at, 1, {part(0), part(1), part(2), 0.7F});
    box.scale = {object.size.x, object.size.y, object.size.z};
    box.orientation = {0, 0, std::sin(object.yaw / 2), std::cos(object.yaw / 2)};
    markers.push_back(box);
    markers.push_back(textAt("object names", object.id, at, object.size.z / 2 + objectTextHeight,
                             objectTextHeight, object.displayName()));
  }
}

}  // namespace

std::vector<ros::Marker> markersOf(const WorldMap& world) {
  ros::Marker clear;
  clear.action = ros::Marker::Action::removeAll;
  std::vector<ros::Marker> markers{clear};
  addPlaces(world.places, markers);
  addAreas(world, markers);
  addObjects(world, markers);
  return markers;
}

RosPublisher::RosPublisher(const LiveView& view, std::unique_ptr<ros::DdsNode> node)
    : view_(view),
      queries_(view),
      node_(std::move(node)),
      where_(node_->publish("/estancia/where", "std_msgs/String")),
      map_(
          node_->publish("/estancia/map", "visualization_msgs/MarkerArray", ros::Durability::transientLocal)),
      thread_([this] { run(); }) {}

RosPublisher::~RosPublisher() {
  over_ = true;
  thread_.join();
}

void RosPublisher::run() {
  constexpr auto patience = std::chrono::milliseconds(200), between = std::chrono::milliseconds(100);
  std::uint64_t revision = 0;
  std::shared_ptr<const WorldMap> published;
  while (!over_) {
    const LiveStatus status = view_.waitForChange(revision, patience);
    if (status.revision == revision) continue;
    revision = status.revision;
    try {
      where_->publish(ros::stringMessage(textOf(queries_.where(status))));
      if (const auto world = view_.world(); world && world != published) {
        map_->publish(ros::markerArrayMessage(markersOf(*world)));
        published = world;
      }
    } catch (const Error& e) {  // a failure of this one does not stop the next change
      spdlog::warn("ROS 2 is not told: {}", e.what());
    }
    std::this_thread::sleep_for(between);
  }
}

}  // namespace estancia
