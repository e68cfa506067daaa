// SPDX-License-Identifier: Apache-2.0
#include "estancia/site/queries.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "estancia/core/fail.hpp"
#include "estancia/core/label_words.hpp"
#include "estancia/map_file/places.hpp"
#include "estancia/words/installed_words.hpp"
#include "estancia/world_query/ask_world.hpp"
#include "estancia/world_query/route_world.hpp"
#include "estancia/world_query/world_json.hpp"

namespace estancia {
namespace {

using Json = nlohmann::ordered_json;

/// Millimeters, and probabilities to a thousandth of a percent.
double shortNumber(double value) {
  return std::round(value * 1e5) / 1e5;
}

Json textOrNothing(const std::string& text) {
  return text.empty() ? Json(nullptr) : Json(text);
}

std::vector<std::string> namesOfPlaces(const WorldMap& world) {
  std::vector<std::string> names;
  const std::vector<int> areas = areasOfNodes(world);
  const std::vector<Place> places = placesOf(world.places);
  for (std::size_t i = 0; i < places.size(); ++i) {
    names.push_back(places[i].displayRoom());
    const WorldArea* area = world.findArea(areas[i]);
    if (area != nullptr && (names.back().empty() || !area->givenName.empty()))
      names.back() = area->displayName();
  }
  return names;
}

/// The most probable place of the robot that the map has: a place that the robot has just come into is not in
/// the map of some seconds ago, and then ways start at the place where the map's last frame is.
std::optional<int> placeOfRobot(const LiveStatus& status, const TopologicalMap& map) {
  if (status.places.empty()) return std::nullopt;
  for (const PlaceBelief& belief : status.places)
    if (map.findNode(belief.node) != nullptr) return belief.node;
  const bool isLocalizing = status.unmapped.has_value();
  if (isLocalizing || map.frames.empty()) return status.places.front().node;
  return map.frames.back().node;
}

std::string whereSentence(const LiveStatus& status, const Json& place, const Json& area) {
  if (status.places.empty()) return "Nobody knows where the robot is: no image came yet";
  if (status.unmapped && *status.unmapped > 0.5)
    return fmt::format("The robot is probably nowhere on the map ({:.0f} %)", 100 * *status.unmapped);
  const std::string at =
      fmt::format("place {} ({:.0f} %)", place["node"].get<int>(), 100 * status.places.front().probability);
  if (!area.is_null()) return fmt::format("In {}, at {}", area["name"].get<std::string>(), at);
  return "At " + at;
}

Json wordsJson(const std::vector<LabelProbability>& words) {
  Json json = Json::array();
  for (const LabelProbability& word : words)
    json.push_back(
        {{"label", word.label}, {"probability", shortNumber(static_cast<double>(word.probability))}});
  return json;
}

Json neighborsJson(const WorldMap& world, int node, const std::vector<Place>& places,
                   const std::vector<std::string>& names) {
  Json json = Json::array();
  const std::size_t index = indexOf(world.places, node);
  for (const auto& [a, b] : linksOf(world.places)) {
    if (a != index && b != index) continue;
    const std::size_t other = a == index ? b : a;
    Json distance;
    if (places[a].position && places[b].position)
      distance = shortNumber(distanceBetween(*places[a].position, *places[b].position));
    json.push_back({{"node", world.places.nodes[other].id},
                    {"name", textOrNothing(names[other])},
                    {"distance", std::move(distance)}});
  }
  return json;
}

Json objectReferences(const WorldMap& world, const auto& isMeant) {
  Json json = Json::array();
  for (const WorldObject& object : world.objects)
    if (isMeant(object)) json.push_back({{"id", object.id}, {"name", object.displayName()}});
  return json;
}

}  // namespace

std::shared_ptr<LiveQueries::Known> LiveQueries::find() const {
  const std::shared_ptr<const WorldMap> world = view_.world();
  if (world == nullptr) return nullptr;
  const auto known = [&] {
    const std::lock_guard lock(mutex_);
    return known_ != nullptr && known_->world == world ? known_ : nullptr;
  };
  if (auto found = known()) return found;
  const std::lock_guard onlyOne(computing_);
  if (auto found = known()) return found;
  std::shared_ptr<Known> fresh(new Known{world, floorOf(*world), namesOfPlaces(*world), {}, {}});
  const std::lock_guard lock(mutex_);
  return known_ = std::move(fresh);
}

std::shared_ptr<LiveQueries::Known> LiveQueries::get() const {
  auto known = find();
  if (known == nullptr)
    fail(ErrorCode::insufficientData,
         "there is no map yet; ask again when the first images have been mapped");
  return known;
}

Json LiveQueries::where() const {
  return where(view_.status());
}

Json LiveQueries::where(const LiveStatus& status) const {
  const auto known = find();
  Json place, area, room, pose, belief = Json::array();
  for (const PlaceBelief& at : status.places)
    belief.push_back({{"node", at.node}, {"probability", shortNumber(at.probability)}});
  if (!status.places.empty()) {
    const int node = status.places.front().node;
    std::string name;
    if (known != nullptr)
      if (const std::size_t i = indexOf(known->world->places, node); i < known->placeNames.size())
        name = known->placeNames[i];
    place = {{"node", node},
             {"name", textOrNothing(name)},
             {"probability", shortNumber(status.places.front().probability)}};
    room = textOrNothing(name);
  }
  if (status.area >= 0) {
    area = {
        {"id", status.area}, {"name", status.areaName}, {"probability", shortNumber(status.areaProbability)}};
    if (const WorldArea* found = known == nullptr ? nullptr : known->world->findArea(status.area);
        found != nullptr && !found->predictedRoom.empty())
      room = found->predictedRoom;
  }
  if (status.pose && status.pose->isPlausible() && known != nullptr) {
    const PlanarPose at = known->floor.project(*status.pose);
    pose = {{"x", shortNumber(at.x)}, {"y", shortNumber(at.y)}, {"yaw", shortNumber(at.heading)}};
  }
  std::string sentence = whereSentence(status, place, area);
  return {{"state", status.state},
          {"frame", textOrNothing(status.frame)},
          {"time", status.timestamp ? Json(*status.timestamp) : Json(nullptr)},
          {"place", std::move(place)},
          {"area", std::move(area)},
          {"room", std::move(room)},
          {"pose", std::move(pose)},
          {"unmapped", status.unmapped ? Json(shortNumber(*status.unmapped)) : Json(nullptr)},
          {"belief", std::move(belief)},
          {"sentence", std::move(sentence)}};
}

Json LiveQueries::status() const {
  return status(view_.status());
}

Json LiveQueries::status(const LiveStatus& status) const {
  return {{"revision", status.revision},
          {"map_revision", status.mapRevision},
          {"state", status.state},
          {"source", status.source},
          {"troubles", status.troubles},
          {"frames", status.frames},
          {"dropped", status.dropped},
          {"failed", status.failed},
          {"where", where(status)},
          {"words", wordsJson(status.words)},
          {"decision", textOrNothing(status.decision)},
          {"latency",
           {{"newest", shortNumber(status.latency)},
            {"median", shortNumber(status.medianLatency)},
            {"p95", shortNumber(status.p95Latency)},
            {"forward", shortNumber(status.forward)}}},
          {"rate", shortNumber(status.rate)}};
}

Json LiveQueries::ask(const std::string& words, std::size_t count) const {
  const auto known = get();
  const WorldMap& world = *known->world;
  try {
    return toJson(words, askWorld(world, words, count, count, installedWordGraph), world);
  } catch (const NoAnswerError&) {
    Json json = toJson(words, WorldAnswers{}, world);
    json["near_spellings"] = findNearNames(world, words);
    return json;
  }
}

Json LiveQueries::route(const RouteQuestion& question) const {
  const auto known = get();
  const std::optional<int> from =
      question.from ? question.from : placeOfRobot(view_.status(), known->world->places);
  if (!from)
    fail(ErrorCode::insufficientData, "nobody knows where the robot is; say from which place the way starts");
  const RegionPreferences regions{question.avoid, question.prefer};
  const std::optional<int> node = wholeNumber<int>(question.to);
  const WorldRoute found =
      node ? routeInWorld(*known->world, *from, *node, regions, {}, installedWordGraph)
           : routeInWorld(*known->world, *from, question.to, regions, {}, installedWordGraph);
  return toJson(node ? "" : question.to, found, *known->world);
}

Json LiveQueries::objects() const {
  const auto known = get();
  Json json{{"objects", Json::array()}};
  for (const WorldObject& object : known->world->objects)
    json["objects"].push_back(toJson(object, *known->world));
  return json;
}

Json LiveQueries::areas() const {
  const auto known = get();
  Json json{{"areas", Json::array()}};
  for (const WorldArea& area : known->world->areas) {
    json["areas"].push_back(toJson(area));
    json["areas"].back()["objects"] = objectReferences(
        *known->world, [&area](const WorldObject& object) { return object.area == area.id; });
  }
  return json;
}

Json LiveQueries::changes(const std::optional<std::size_t>& since) const {
  const auto known = get();
  Json json = view_.changes(since);
  for (Json& change : json["objects"])
    for (const auto& [key, at] : {std::pair("from", "from_at"), std::pair("to", "to_at")}) {
      if (!change.contains(key)) continue;
      const Json& p = change[key];
      const cv::Point2d point = known->floor.position({p[0], p[1], p[2]});
      change[at] = {shortNumber(point.x), shortNumber(point.y)};
    }
  return json;
}

Json LiveQueries::place(int node) const {
  const auto known = get();
  const WorldMap& world = *known->world;
  const Node& found = world.places.getNode(node);
  const std::vector<Place> places = placesOf(world.places);
  const std::size_t index = indexOf(world.places, node);
  std::vector<LabelProbability> words;
  for (const std::size_t label : bestLabels(found, 10))
    words.push_back({world.places.vocabulary[label], found.mean.at(label)});
  Json position;
  if (const auto& at = places[index].position) {
    const cv::Point2d point = known->floor.position(cv::Vec3d(at->data()));
    position = {shortNumber(point.x), shortNumber(point.y)};
  }
  return {{"node", node},
          {"name", textOrNothing(known->placeNames[index])},
          {"room", textOrNothing(places[index].displayRoom())},
          {"area", areaReference(world, world.areaOfNode(node))},
          {"position", std::move(position)},
          {"frames", found.frames},
          {"words", wordsJson(words)},
          {"neighbors", neighborsJson(world, node, places, known->placeNames)},
          {"objects", objectReferences(world, [&](const WorldObject& object) {
             return world.places.frames.at(object.bestFrame).node == node;
           })}};
}

std::shared_ptr<const std::string> LiveQueries::map() const {
  // Read before the world: a newer map under an older number only causes one more request.
  const std::uint64_t revision = view_.status().mapRevision;
  const auto known = get();
  const std::lock_guard lock(known->drawing);
  if (known->map == nullptr) {
    Json json{{"map_revision", revision}};
    json.update(drawMap(*known->world, known->floor, known->placeNames));
    known->map = std::make_shared<const std::string>(textOf(json));
  }
  return known->map;
}

std::string textOf(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace estancia
