// SPDX-License-Identifier: Apache-2.0
#include "estancia/world_query/world_json.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "estancia/map_file/places.hpp"
#include "estancia/query/map_json.hpp"

namespace estancia {
namespace {

using Json = nlohmann::ordered_json;

/// Rounds to millimeters, which suffice.
double inMillimeters(double meters) {
  return std::round(meters * 1e3) / 1e3;
}

Json pointJson(const cv::Point3d& point) {
  return {inMillimeters(point.x), inMillimeters(point.y), inMillimeters(point.z)};
}

Json knownJson(const WorldObject& object, const WorldMap& world) {
  if (!object.known) return nullptr;
  const Pose& p = object.known->pose;
  Json orientation = Json::array();
  for (const double part : {p.qx, p.qy, p.qz, p.qw}) orientation.push_back(std::round(part * 1e5) / 1e5);
  return {{"name", object.known->name},
          {"confidence", std::round(object.known->confidence * 1e6) / 1e6},
          {"position", pointJson({p.x, p.y, p.z})},
          {"orientation", orientation},
          {"frame", world.places.frames.at(object.known->frame).name}};
}

Json shapeJson(const WorldObject& object) {
  if (object.shapeClasses.empty()) return nullptr;
  Json classes = Json::object();
  const auto share = [](const LabelProbability& of) {
    return std::round(static_cast<double>(of.probability) * 1e6) / 1e6;
  };
  for (const LabelProbability& of : object.shapeClasses) classes[of.label] = share(of);
  const LabelProbability& best = object.shapeClasses.front();
  return {{"class", best.label}, {"probability", share(best)}, {"classes", std::move(classes)}};
}

Json textOrNull(const std::string& text) {
  return text.empty() ? Json(nullptr) : Json(text);
}

double shortened(double probability) {
  return std::round(probability * 1e6) / 1e6;
}

Json wayJson(const DrivenWay& way) {
  Json path = Json::array();
  for (const cv::Point2d& point : way.points)
    path.push_back({inMillimeters(point.x), inMillimeters(point.y)});
  return {{"length", inMillimeters(way.length)}, {"path", path}};
}

Json crossedJson(const CrossedRegion& crossed) {
  constexpr const char* why[] = {"goal", "start", "detour"};
  return {{"region", crossed.name},
          {"length", crossed.length > 0 ? Json(inMillimeters(crossed.length)) : Json(nullptr)},
          {"why", why[static_cast<int>(crossed.why)]}};
}

void addRegions(const char* use, const std::vector<MapRegion>& regions, const WorldMap& world, Json& json) {
  for (const MapRegion& region : regions) {
    Json entry{{"region", region.name}, {"use", use}, {"areas", Json::array()}, {"nodes", Json::array()}};
    for (const int area : region.areas) entry["areas"].push_back(areaReference(world, area));
    for (std::size_t i = 0; i < region.places.size(); ++i)
      if (region.places[i]) entry["nodes"].push_back(world.places.nodes[i].id);
    entry.update(toJson(region.meaning, world.places.vocabulary));
    json.push_back(std::move(entry));
  }
}

Json momentJson(const TopologicalMap& map, std::size_t i) {
  const MappedFrame& frame = map.frames.at(i);
  return {{"frame", frame.name},
          {"number", frame.number},
          {"drive", map.driveOf(i)},
          {"time", frame.timestamp ? Json(*frame.timestamp) : Json(nullptr)}};
}

Json answerJson(const ObjectAnswer& answer, const WorldMap& world) {
  Json object = toJson(*world.findObject(answer.object), world);
  object["probability"] = shortened(answer.probability);
  object["lift"] = shortened(answer.lift);
  object["label"] = textOrNull(answer.label);
  object["rank"] = answer.rank == 0 ? Json(nullptr) : Json(answer.rank);
  object["named"] = answer.isNamed;
  object["recognized"] = answer.isKnown;
  object["by_shape"] = answer.isShaped;
  return object;
}

}  // namespace

Json areaReference(const WorldMap& world, int area) {
  const WorldArea* found = world.findArea(area);
  if (found == nullptr) return nullptr;
  return {{"id", area}, {"name", found->displayName()}};
}

Json toJson(const WorldArea& area) {
  return {{"id", area.id},
          {"name", area.displayName()},
          {"given_name", textOrNull(area.givenName)},
          {"predicted_room", textOrNull(area.predictedRoom)},
          {"room_probability",
           area.predictedRoom.empty() ? Json(nullptr) : Json(shortened(area.roomProbability))},
          {"size", inMillimeters(area.size)},
          {"center", {inMillimeters(area.center.x), inMillimeters(area.center.y)}},
          {"frames", area.frames}};
}

Json toJson(const WorldObject& object, const WorldMap& world) {
  const WorldObject* below = world.findObject(object.onObject);
  return {{"id", object.id},
          {"name", object.displayName()},
          {"probability", shortened(object.probability())},
          {"given_name", textOrNull(object.givenName)},
          {"known", knownJson(object, world)},
          {"shape", shapeJson(object)},
          {"position", pointJson(object.center)},
          {"size", pointJson(object.size)},
          {"yaw", inMillimeters(object.yaw)},
          {"support", textOrNull(supportNames[static_cast<std::size_t>(object.support)])},
          {"on", below == nullptr ? Json(nullptr) : Json{{"id", below->id}, {"name", below->displayName()}}},
          {"area", areaReference(world, object.area)},
          {"views", object.views},
          {"first_seen", momentJson(world.places, object.firstFrame)},
          {"last_seen", momentJson(world.places, object.lastFrame)},
          {"image", world.places.frames.at(object.bestFrame).name}};
}

Json toJson(const std::string& words, const WorldAnswers& answers, const WorldMap& world) {
  const Answers ofPlaces{static_cast<const Meaning&>(answers), answers.places};
  Json json = toJson(words, ofPlaces, world.places, placesOf(world.places));
  Json places = std::move(json["places"]);
  json.erase("places");  // they come last
  for (const char* key : {"near_spellings", "areas", "objects"}) json[key] = Json::array();
  json["places"] = std::move(places);
  for (const int area : answers.areas) json["areas"].push_back(toJson(*world.findArea(area)));
  for (const ObjectAnswer& answer : answers.objects) json["objects"].push_back(answerJson(answer, world));
  for (Json& place : json["places"])
    if (!world.areas.empty()) place["area"] = areaReference(world, world.areaOfNode(place["node"]));
  return json;
}

Json toJson(const std::string& words, const WorldRoute& found, const WorldMap& world) {
  Json json = toJson(found.route);
  if (found.driven) json["cost"] = inMillimeters(found.driven->length);
  json["driven"] = found.driven ? wayJson(*found.driven) : Json(nullptr);
  if (!words.empty()) {
    json["words"] = words;
    json.update(toJson(found.meaning, world.places.vocabulary));
  }
  if (found.object) {
    const ViewPose& pose = *found.pose;
    json["goal"] = "object";
    json["object"] = answerJson(*found.object, world);
    json["pose"] = {{"x", inMillimeters(pose.x)},
                    {"y", inMillimeters(pose.y)},
                    {"yaw", inMillimeters(pose.yaw)},
                    {"frame", world.places.frames.at(pose.frame).name},
                    {"distance", inMillimeters(pose.distance)}};
  } else if (found.area >= 0) {
    json["goal"] = "area";
    json["area"] = areaReference(world, found.area);
  } else if (found.place) {
    json["goal"] = "place";
    if (found.place->room.empty())
      json["label"] = world.places.vocabulary[found.place->label];
    else
      json["room"] = found.place->room;
    json["probability"] = found.place->probability;
  }
  json["regions"] = Json::array();
  addRegions("avoid", found.regions.avoid, world, json["regions"]);
  addRegions("prefer", found.regions.prefer, world, json["regions"]);
  json["crossed"] = Json::array();
  for (const CrossedRegion& crossed : found.crossed) json["crossed"].push_back(crossedJson(crossed));
  if (world.areas.empty()) return json;
  json["areas"] = Json::array();
  for (const int area : found.areas) json["areas"].push_back(areaReference(world, area));
  return json;
}

std::string knownText(const WorldObject& object) {
  if (!object.known) return "";
  const Pose& p = object.known->pose;
  return fmt::format(
      "recognized as {} ({:.0f} %), its axes at ({:.2f}, {:.2f}, {:.2f}) m, turned by ({:.3f}, {:.3f}, "
      "{:.3f}, "
      "{:.3f})",
      object.known->name, 100 * object.known->confidence, p.x, p.y, p.z, p.qx, p.qy, p.qz, p.qw);
}

std::string shapeText(const WorldObject& object) {
  if (object.shapeClass() == nullptr) return "";
  return fmt::format("by its shape {} ({:.0f} %)", *object.shapeClass(),
                     100 * static_cast<double>(object.shapeClasses.front().probability));
}

std::string supportText(const WorldObject& object, const WorldMap& world) {
  switch (object.support) {
    case Support::floor:
      return "on the floor";
    case Support::object:
      if (const WorldObject* below = world.findObject(object.onObject))
        return "on the " + below->displayName();
      return "on an object";
    case Support::surface:
      return "on a surface";
    case Support::wall:
      return "at a wall";
    case Support::unknown:
      break;
  }
  return "";
}

}  // namespace estancia
