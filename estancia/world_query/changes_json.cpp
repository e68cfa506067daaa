// Changes as JSON, for the command, the API and agents.
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <nlohmann/json.hpp>

#include "estancia/world_query/changes.hpp"
#include "estancia/world_query/world_json.hpp"

namespace estancia {
namespace {

using Json = nlohmann::ordered_json;

/// The object that it is or was a part of; nullptr where that is none.
const WorldObject* thingOf(const ObjectChange& change, const WorldMap& world) {
  const auto object = change.now ? change.now : change.before;
  return object ? world.findObject(*object) : nullptr;
}

Json roundedJson(const cv::Point3d& p) {
  const auto inMillimeters = [](double meters) { return std::round(meters * 1e3) / 1e3; };
  return {inMillimeters(p.x), inMillimeters(p.y), inMillimeters(p.z)};
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
    json["from"] = roundedJson(change.from);
    json["from_area"] = areaJson(change.from, world);
    json["last_seen"] = world.places.frames.at(change.lastBefore).name;
  }
  if (change.kind != ObjectChange::Kind::gone) {
    json["to"] = roundedJson(change.to);
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
  if (thing == nullptr) return "something";
  return (change.isWhole ? "" : "part of ") + thing->displayName();
}

nlohmann::ordered_json toJson(const Changes& changes) {
  Json objects = Json::array(), places = Json::array();
  for (const ObjectChange& change : changes.objects) objects.push_back(changeJson(change, *changes.world));
  for (const PlaceChange& change : changes.places) places.push_back(changeJson(change));
  return {{"since", changes.since}, {"objects", std::move(objects)}, {"places", std::move(places)}};
}

}  // namespace estancia
