// SPDX-License-Identifier: Apache-2.0
#include "estancia/world_query/export_world.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "estancia/core/error.hpp"
#include "estancia/core/label_words.hpp"
#include "estancia/query/export_text.hpp"
#include "estancia/world_query/layer_tree.hpp"
#include "estancia/world_query/world_json.hpp"

namespace estancia {
namespace {

using Json = nlohmann::ordered_json;
using exporting::data;
using exporting::rounded;

constexpr int roomsVersion = 1;

Json cornersOf(const WorldArea& area) {
  Json corners = Json::array();
  for (const cv::Point2d& corner : area.outline)
    corners.push_back({std::round(corner.x * 1e3) / 1e3, std::round(corner.y * 1e3) / 1e3});
  return corners;
}

Json objectJson(const WorldObject& object, const WorldMap& world, std::size_t maxWords) {
  Json json = toJson(object, world);
  json["words"] = Json::array();
  for (std::size_t i = 0; i < std::min(maxWords, object.words.size()); ++i)
    json["words"].push_back({{"label", object.words[i].label}, {"p", rounded(object.words[i].probability)}});
  return json;
}

std::string toAreasJson(const WorldMap& world, const ExportOptions& options) {
  if (world.areas.empty())
    throw Error(ErrorCode::unsupportedFile,
                "the map has no areas, as --format rooms needs; map a drive with depth, or export a "
                "file of zones");
  const TopologicalMap& map = world.places;
  const LayerTree tree(world);
  Json rooms = Json::array(), elsewhere = Json::array();
  for (const WorldArea& area : world.areas) {
    Json room = toJson(area);
    room["outline"] = cornersOf(area);
    room["neighbors"] = Json::array();
    room["places"] = Json::array();
    room["objects"] = Json::array();  // where no place is in it
    for (const int object : tree.objectsBesidePlaces(area.id))
      room["objects"].push_back(objectJson(*world.findObject(object), world, options.maxWords));
    rooms.push_back(std::move(room));
  }
  std::vector<Json> ranges = exporting::frameRanges(map);
  for (std::size_t i = 0; i < map.nodes.size(); ++i) {
    const Node& node = map.nodes[i];
    Json place{{"id", node.id},
               {"words", Json::array()},
               {"position", nullptr},
               {"frames", node.frames},
               {"frame_ranges", std::move(ranges[i])},
               {"objects", Json::array()}};
    for (const std::size_t label : bestLabels(node, options.maxWords))
      place["words"].push_back({{"label", map.vocabulary[label]}, {"p", rounded(node.mean[label])}});
    if (tree.places[i].position) place["position"] = *tree.places[i].position;
    for (const int object : tree.objectsOf(i))
      place["objects"].push_back(objectJson(*world.findObject(object), world, options.maxWords));
    const int area = tree.areaOfNode[i];
    (area < 0 ? elsewhere : rooms[static_cast<std::size_t>(area)]["places"]).push_back(std::move(place));
  }
  for (const auto& [one, other] : tree.neighbors) {  // ascending for each
    rooms[static_cast<std::size_t>(one)]["neighbors"].push_back(other);
    rooms[static_cast<std::size_t>(other)]["neighbors"].push_back(one);
  }
  return exporting::dump({{"format", "estancia-rooms"},
                          {"version", roomsVersion},
                          {"rooms", std::move(rooms)},
                          {"elsewhere", {{"places", std::move(elsewhere)}}}});
}

Json feature(const char* geometry, Json coordinates, std::size_t id, const std::string& frame,
             Json metadata) {
  return {{"type", "Feature"},
          {"properties", {{"id", id}, {"frame", frame}, {"metadata", std::move(metadata)}}},
          {"geometry", {{"type", geometry}, {"coordinates", std::move(coordinates)}}}};
}

std::string addToNav2(const WorldMap& world, const ExportOptions& options) {
  Json graph = Json::parse(exportMap(world.places, "nav2", options));
  const LayerTree tree(world);
  Json& features = graph["features"];
  for (std::size_t i = 0; i < tree.places.size(); ++i) {  // nodes come first, in this order
    Json& metadata = features[i]["properties"]["metadata"];
    if (const WorldArea* area = world.findArea(tree.areaOfNode[i])) {
      metadata["area"] = area->displayName();
      metadata["area_id"] = area->id;
    }
    Json names = Json::array();
    for (const int object : tree.objectsOf(i)) names.push_back(world.findObject(object)->displayName());
    if (!names.empty()) metadata["objects"] = std::move(names);
  }
  auto id = features.back()["properties"]["id"].get<std::size_t>();
  for (const WorldArea& area : world.areas) {
    if (area.outline.size() < 3) continue;
    Json ring = cornersOf(area);
    ring.push_back(Json(ring.front()));  // RFC 7946, 3.1.6: the last position is the first
    features.push_back(feature("Polygon", Json::array({std::move(ring)}), ++id, options.frame,
                               {{"class", "area"},
                                {"name", area.displayName()},
                                {"area_id", area.id},
                                {"size", area.size},
                                {"frames", area.frames}}));
  }
  for (const WorldObject& object : world.objects) {
    Json metadata{{"class", "object"},
                  {"name", object.displayName()},
                  {"object_id", object.id},
                  {"probability", rounded(object.probability())},
                  {"position", {object.center.x, object.center.y, object.center.z}},
                  {"size", {object.size.x, object.size.y, object.size.z}},
                  {"yaw", object.yaw},
                  {"views", object.views}};
    if (object.known) {
      const Pose& p = object.known->pose;
      metadata["known"] = {{"name", object.known->name},
                           {"position", {p.x, p.y, p.z}},
                           {"orientation", {p.qx, p.qy, p.qz, p.qw}}};
    }
    if (object.area >= 0) metadata["area_id"] = object.area;
    if (const std::string on = supportText(object, world); !on.empty()) metadata["support"] = on;
    features.push_back(feature("MultiPoint", Json::array({Json::array({object.center.x, object.center.y})}),
                               ++id, options.frame, std::move(metadata)));
  }
  return exporting::dump(graph);
}

std::string numbered(const char* key, double value) {
  return data(key, fmt::format("{}", value));
}

std::string relation(const std::string& source, const std::string& target, const char* name) {
  return fmt::format("    <edge source=\"{}\" target=\"{}\">\n{}    </edge>\n", source, target,
                     data("relation", name));
}

std::string graphmlObject(const WorldObject& object, const ExportOptions& options) {
  std::vector<std::string> words;
  for (std::size_t i = 0; i < std::min(options.maxWords, object.words.size()); ++i)
    words.push_back(shortLabel(object.words[i].label));
  return fmt::format("    <node id=\"o{}\">\n", object.id) + data("kind", "object") +
         data("name", object.displayName()) + data("words", fmt::format("{}", fmt::join(words, ", "))) +
         numbered("probability", rounded(object.probability())) + numbered("x", object.center.x) +
         numbered("y", object.center.y) + numbered("z", object.center.z) + numbered("size_x", object.size.x) +
         numbered("size_y", object.size.y) + numbered("size_z", object.size.z) + numbered("yaw", object.yaw) +
         data("frames", std::to_string(object.views)) + "    </node>\n";
}

std::string graphmlArea(const WorldArea& area) {
  return fmt::format("    <node id=\"a{}\">\n", area.id) + data("kind", "area") +
         data("name", area.displayName()) + numbered("floor_area", area.size) + numbered("x", area.center.x) +
         numbered("y", area.center.y) + data("frames", std::to_string(area.frames)) + "    </node>\n";
}

std::string addToGraphml(const WorldMap& world, const ExportOptions& options) {
  std::string text = exportMap(world.places, "graphml", options);
  std::string keys;
  for (const auto& [name, element, type] : {std::array{"kind", "node", "string"},
                                            {"name", "node", "string"},
                                            {"probability", "node", "double"},
                                            {"floor_area", "node", "double"},
                                            {"size_x", "node", "double"},
                                            {"size_y", "node", "double"},
                                            {"size_z", "node", "double"},
                                            {"yaw", "node", "double"},
                                            {"relation", "edge", "string"}})
    keys += fmt::format("  <key id=\"{0}\" for=\"{1}\" attr.name=\"{0}\" attr.type=\"{2}\"/>\n", name,
                        element, type);
  // Texts are escaped: no other `<` stands in the file.
  text.insert(text.find("  <graph "), keys);
  const LayerTree tree(world);
  const auto nodeName = [&world](std::size_t i) { return fmt::format("n{}", world.places.nodes[i].id); };
  std::string more;
  for (const WorldArea& area : world.areas) more += graphmlArea(area);
  for (const WorldObject& object : world.objects) more += graphmlObject(object, options);
  for (std::size_t i = 0; i < tree.places.size(); ++i)
    if (tree.areaOfNode[i] >= 0) more += relation(nodeName(i), fmt::format("a{}", tree.areaOfNode[i]), "in");
  for (const WorldObject& object : world.objects) {
    const std::string name = fmt::format("o{}", object.id);
    if (object.area >= 0) more += relation(name, fmt::format("a{}", object.area), "in");
    if (const std::size_t i = tree.nodeOfObject[static_cast<std::size_t>(object.id)]; i < tree.places.size())
      more += relation(name, nodeName(i), "at");
    if (object.onObject >= 0) more += relation(name, fmt::format("o{}", object.onObject), "on");
  }
  text.insert(text.rfind("  </graph>"), more);
  return text;
}

struct WorldFormat {
  const char *name, *explanation;
  std::string (*write)(const WorldMap&, const ExportOptions&);
};
/// Formats that exportMap() lacks.
constexpr WorldFormat formats[] = {
    {"rooms", "areas, their places and objects, as simple JSON", toAreasJson},
    {"spark-dsg", "3-D scene graph for Spark-DSG (Hydra) and its viewers; needs poses",
     [](const WorldMap& world, const ExportOptions&) { return exporting::dump(sparkDsgJson(world)); }}};

}  // namespace

Choices worldFormats() {
  Choices choices = exportFormats();
  for (const WorldFormat& format : formats) choices.push_back({format.name, format.explanation});
  return choices;
}

bool listsFrames(const std::string& format) {
  return format == "json" || format == "rooms";
}

std::string exportWorld(const WorldMap& world, const std::string& format, const ExportOptions& options) {
  requireChoice("export format", format, worldFormats());
  if (const auto* found = std::ranges::find(formats, format, &WorldFormat::name); found != std::end(formats))
    return found->write(world, options);
  const bool onlyPlaces = world.areas.empty() && world.objects.empty();
  if (!onlyPlaces && format == "nav2") return addToNav2(world, options);
  if (!onlyPlaces && format == "graphml") return addToGraphml(world, options);
  return exportMap(world.places, format, options);
}

}  // namespace estancia
