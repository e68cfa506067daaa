// SPDX-License-Identifier: Apache-2.0
#include "estancia/world_query/world_json.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "estancia/map_file/places.hpp"
#include "estancia/query/map_json.hpp"
#include "estancia/world_query/changes.hpp"

namespace estancia {
namespace {

using Json = nlohmann::ordered_json;

/// Rounds to millimeters, which suffice.
double inMillimeters(double meters) {
  return std::round(meters * 1e3) / 1e3;
}

double shortened(double probability) {
  return std::round(probability * 1e6) / 1e6;
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
          {"confidence", shortened(object.known->confidence)},
          {"position", pointJson({p.x, p.y, p.z})},
          {"orientation", orientation},
          {"frame", world.places.frames.at(object.known->frame).name}};
}

Json shapeJson(const WorldObject& object) {
  if (object.shapeClasses.empty()) return nullptr;
  Json classes = Json::object();
  for (const LabelProbability& of : object.shapeClasses) classes[of.label] = shortened(of.probability);
  const LabelProbability& best = object.shapeClasses.front();
  return {
      {"class", best.label}, {"probability", shortened(best.probability)}, {"classes", std::move(classes)}};
}

Json textOrNull(const std::string& text) {
  return text.empty() ? Json(nullptr) : Json(text);
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
      "{:.3f}, {:.3f})",
      object.known->name, 100 * object.known->confidence, p.x, p.y, p.z, p.qx, p.qy, p.qz, p.qw);
}

std::string shapeText(const WorldObject& object) {
  if (object.shapeClass() == nullptr) return "";
  return fmt::format("by its shape {} ({:.0f} %)", *object.shapeClass(),
                     100 * static_cast<double>(object.shapeClasses.front().probability));
}

std::string supportText(const WorldObject& object, const WorldMap& world) {
  if (object.support == Support::object) {
    const WorldObject* below = world.findObject(object.onObject);
    return below == nullptr ? "on an object" : "on the " + below->displayName();
  }
  return object.support == Support::floor     ? "on the floor"
         : object.support == Support::surface ? "on a surface"
         : object.support == Support::wall    ? "at a wall"
                                              : "";
}

namespace {

/// The object that it is or was a part of; nullptr where that is none.
const WorldObject* thingOf(const ObjectChange& change, const WorldMap& world) {
  const auto object = change.now ? change.now : change.before;
  return object ? world.findObject(*object) : nullptr;
}

Json areaJson(const cv::Point3d& at, const WorldMap& world) {
  return world.plan ? areaReference(world, areaOfObject(*world.plan, at)) : Json();
}

Json changeJson(const ObjectChange& change, const WorldMap& world) {
  const auto number = [](const std::optional<int>& object) { return object ? Json(*object) : Json(); };
  const WorldObject* thing = thingOf(change, world);
  Json json{
      {"kind", toString(change.kind)},    {"name", thing != nullptr ? Json(thing->displayName()) : Json()},
      {"whole", change.isWhole},          {"object_before", number(change.before)},
      {"object_now", number(change.now)}, {"area_m2", std::round(change.area * 1e4) / 1e4}};
  if (change.kind != ObjectChange::Kind::appeared) {
    json["from"] = pointJson(change.from);
    json["from_area"] = areaJson(change.from, world);
    json["last_seen"] = world.places.frames.at(change.lastBefore).name;
  }
  if (change.kind != ObjectChange::Kind::gone) {
    json["to"] = pointJson(change.to);
    json["to_area"] = areaJson(change.to, world);
    json["first_seen"] = world.places.frames.at(change.firstNow).name;
  }
  return json;
}

Json changeJson(const PlaceChange& change) {
  Json words = Json::array();
  for (const PlaceChange::Word& word : change.words)
    words.push_back({{"label", word.label}, {"before", word.before}, {"now", word.now}});
  return {{"node", change.node}, {"distance", change.distance}, {"words", std::move(words)}};
}

}  // namespace

std::string nameOf(const ObjectChange& change, const WorldMap& world) {
  const WorldObject* thing = thingOf(change, world);
  return thing == nullptr ? "something" : (change.isWhole ? "" : "part of ") + thing->displayName();
}

nlohmann::ordered_json toJson(const Changes& changes) {
  Json objects = Json::array(), places = Json::array();
  for (const ObjectChange& change : changes.objects) objects.push_back(changeJson(change, *changes.world));
  for (const PlaceChange& change : changes.places) places.push_back(changeJson(change));
  return {{"since", changes.since}, {"objects", std::move(objects)}, {"places", std::move(places)}};
}

}  // namespace estancia
