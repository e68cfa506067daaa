// SPDX-License-Identifier: Apache-2.0
#include "estancia/world_query/export_world.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>
#include <vector>

#include "estancia/core/error.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/label_words.hpp"
#include "estancia/map_file/places.hpp"
#include "estancia/query/export_text.hpp"
#include "estancia/world_query/ask_world.hpp"
#include "estancia/world_query/world_json.hpp"

namespace estancia {
namespace {

/// Areas → places → objects as a tree, for formats where everything has one parent.
struct LayerTree {
  explicit LayerTree(const WorldMap& world);

  std::vector<Place> places;
  /// In the order of map.nodes; -1 for none.
  std::vector<int> areaOfNode;
  /// For each object an index into map.nodes: of the places in its area the nearest; where it is in no area,
  /// the place of the frame that shows it best; map.nodes.size() where its area has no places.
  std::vector<std::size_t> nodeOfObject;
  std::vector<int> areaOfObject;
  /// Areas that a transition leads between, the smaller number first.
  std::set<std::pair<int, int>> neighbors;

  std::vector<int> objectsOf(std::size_t node) const;
  /// The objects of an area that has no places.
  std::vector<int> objectsBesidePlaces(int area) const;
};

LayerTree::LayerTree(const WorldMap& world)
    : places(placesOf(world.places)), areaOfNode(areasOfNodes(world)) {
  for (const WorldObject& object : world.objects) {
    areaOfObject.push_back(object.area);
    std::size_t nearest = places.size();
    double distance = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < places.size() && object.area >= 0; ++i) {
      if (areaOfNode[i] != object.area) continue;
      const double here =
          places[i].position
              ? distanceBetween(*places[i].position, {object.center.x, object.center.y, object.center.z})
              : std::numeric_limits<double>::max();
      if (here < distance) nearest = i, distance = here;
    }
    if (object.area < 0) nearest = indexOf(world.places, world.places.frames.at(object.bestFrame).node);
    nodeOfObject.push_back(nearest);
  }
  for (const auto& [a, b] : linksOf(world.places)) {
    const auto [low, high] = std::minmax(areaOfNode[a], areaOfNode[b]);
    if (low >= 0 && low != high) neighbors.emplace(low, high);
  }
}

std::vector<int> LayerTree::objectsOf(std::size_t node) const {
  std::vector<int> objects;
  for (std::size_t i = 0; i < nodeOfObject.size(); ++i)
    if (nodeOfObject[i] == node) objects.push_back(static_cast<int>(i));
  return objects;
}

std::vector<int> LayerTree::objectsBesidePlaces(int area) const {
  std::vector<int> objects;
  for (std::size_t i = 0; i < nodeOfObject.size(); ++i)
    if (nodeOfObject[i] == places.size() && areaOfObject[i] == area) objects.push_back(static_cast<int>(i));
  return objects;
}

using Json = nlohmann::ordered_json;

// Spark-DSG: the format was read off MIT-SPARK/Spark-DSG: src/serialization/graph_json_serialization.cpp and
// json_conversions.cpp, src/node_attributes.cpp and edge_attributes.cpp (which fields there are, since which
// version), include/spark_dsg/node_symbol.h and scene_graph_types.h (ids, layers), and
// python/tests/resources/apartment_igx_dsg.json. Encoding 1.0.3 is the oldest that has the present colors and
// boxes; readers from 1.1 on give its layers their names. Fields that a reader does not know are skipped.

/// The directions of a floor's two axes and of up in the map, as columns.
cv::Matx33d axesOf(const Floor& floor) {
  cv::Matx33d axes;
  for (int i = 0; i < 3; ++i) {
    cv::Vec3d unit;
    unit[i] = 1;
    const cv::Point2d at = floor.position(unit);
    axes(i, 0) = at.x, axes(i, 1) = at.y, axes(i, 2) = floor.up()[i];
  }
  return axes;
}

enum Layer { objectLayer = 2, placeLayer = 3, roomLayer = 4, buildingLayer = 5 };
constexpr std::uint32_t noLabel = std::numeric_limits<std::uint32_t>::max();

/// A node's id: a letter in the highest byte, its number in the others.
std::uint64_t idOf(char key, int number) {
  return static_cast<std::uint64_t>(key) << 56U | static_cast<std::size_t>(number);
}

Json vectorJson(const cv::Vec3d& vector) {
  return {vector[0], vector[1], vector[2]};
}

Json quaternionJson(const cv::Matx33d& rotation) {
  const Pose pose = poseOf(cv::Affine3d(rotation, cv::Vec3d()));
  return {{"w", pose.qw}, {"x", pose.qx}, {"y", pose.qy}, {"z", pose.qz}};
}

Json boxJson(const char* type, const cv::Vec3d& size, const cv::Vec3d& center, const cv::Matx33d& rotation) {
  return {{"type", type},
          {"dimensions", vectorJson(size)},
          {"world_P_center", vectorJson(center)},
          {"world_R_center", quaternionJson(rotation)}};
}

/// Attributes of every semantic node.
Json attributesOf(const char* type, const std::string& name, const cv::Vec3d& position, std::uint64_t time) {
  return {{"type", type},
          {"position", vectorJson(position)},
          {"last_update_time_ns", time},
          {"is_active", false},
          {"is_predicted", false},
          {"name", name},
          {"color", {{"r", 0}, {"g", 0}, {"b", 0}, {"a", 255}}},
          {"bounding_box", boxJson("INVALID", {}, position, cv::Matx33d::eye())},
          {"semantic_label", noLabel},
          {"semantic_feature", {{"rows", 0}, {"cols", 0}, {"data", Json::array()}}}};
}

std::uint64_t nanoseconds(const MappedFrame& frame) {
  const double time = frame.timestamp.value_or(0) * 1e9;
  return time > 0 && time < 9e18 ? static_cast<std::uint64_t>(time) : 0;
}

/// Spark-DSG export. Life cycle: the constructor adds objects, places and rooms in this order, then json()
/// takes the result. Invariant: an edge is added after both of its nodes.
class SceneGraph {
 public:
  explicit SceneGraph(const WorldMap& world) : world_(world), tree_(world) {
    requirePositions();
    if (world.plan) axes_ = axesOf(world.plan->floor);
    addObjects();
    addPlaces();
    if (!world.areas.empty()) addRooms();
  }

  Json json() && {
    return {{"SPARK_DSG_header",
             {{"project_name", "main"}, {"version", {{"major", 1}, {"minor", 0}, {"patch", 3}}}}},
            {"directed", false},
            {"multigraph", false},
            {"layer_ids", {objectLayer, placeLayer, roomLayer, buildingLayer}},
            {"metadata",
             {{"estancia", {{"version", 1}, {"vocabulary", world_.places.vocabulary.digest()}}},
              {"labels", labels_}}},
            {"nodes", std::move(nodes_)},
            {"edges", std::move(edges_)}};
  }

 private:
  void requirePositions() const {
    const auto lost = std::ranges::count_if(tree_.places, [](const Place& place) { return !place.position; });
    if (lost > 0)
      fail(ErrorCode::insufficientData,
           "{} of the map's {} places have no position, which Spark-DSG needs; map the drive with its poses",
           lost, tree_.places.size());
  }

  void addObjects() {
    const bool upright = std::abs(axes_(2, 2) - 1) < 1e-6;
    for (const WorldObject& object : world_.objects) {
      const cv::Vec3d center = object.center, size = object.size;
      Json attributes = attributesOf("ObjectNodeAttributes", object.displayName(), center,
                                     nanoseconds(world_.places.frames.at(object.lastFrame)));
      const cv::Matx33d turn(std::cos(object.yaw), -std::sin(object.yaw), 0,  //
                             std::sin(object.yaw), std::cos(object.yaw), 0, 0, 0, 1);
      attributes["color"] = {
          {"r", object.color[0]}, {"g", object.color[1]}, {"b", object.color[2]}, {"a", 255}};
      if (std::min({size[0], size[1], size[2]}) > 0)
        attributes["bounding_box"] = boxJson(upright ? "RAABB" : "OBB", size, center, axes_ * turn);
      const auto& labels = world_.places.vocabulary.labels();
      const auto best =
          object.words.empty() ? labels.end() : std::ranges::find(labels, object.words.front().label);
      if (best != labels.end()) {
        attributes["semantic_label"] = best - labels.begin();
        labels_[std::to_string(best - labels.begin())] = shortLabel(*best);
      }
      attributes["mesh_connections"] = Json::array();
      attributes["registered"] = false;
      attributes["world_R_object"] = quaternionJson(axes_ * turn);
      const std::uint64_t id = idOf('O', object.id);
      addNode(id, objectLayer, std::move(attributes));
      if (object.onObject >= 0) addEdge(idOf('O', object.onObject), id);
      const std::size_t node = tree_.nodeOfObject[static_cast<std::size_t>(object.id)];
      addEdge(node < tree_.places.size() ? idOf('p', world_.places.nodes[node].id) : idOf('R', object.area),
              id);
    }
  }

  void addPlaces() {
    const TopologicalMap& map = world_.places;
    const auto idOfPlace = [&map](std::size_t i) { return idOf('p', map.nodes[i].id); };
    std::vector<std::uint64_t> times(map.nodes.size());
    for (const MappedFrame& frame : map.frames)
      if (const std::size_t i = indexOf(map, frame.node); i < times.size())
        times[i] = std::max(times[i], nanoseconds(frame));
    for (std::size_t i = 0; i < map.nodes.size(); ++i) {
      const Position& at = *tree_.places[i].position;
      std::string name = tree_.places[i].displayRoom();
      const std::vector<std::size_t> best = bestLabels(map.nodes[i], 1);
      if (name.empty() && !best.empty()) name = shortLabel(map.vocabulary[best.front()]);
      Json attributes = attributesOf("PlaceNodeAttributes", name, {at[0], at[1], at[2]}, times[i]);
      attributes["distance"] = 0;
      attributes["num_basis_points"] = 0;
      for (const char* none : {"voxblox_mesh_connections", "pcl_mesh_connections", "mesh_vertex_labels",
                               "deformation_connections"})
        attributes[none] = Json::array();
      attributes["real_place"] = true;
      attributes["active_frontier"] = false;
      attributes["frontier_scale"] = {0, 0, 0};
      attributes["orientation"] = quaternionJson(cv::Matx33d::eye());
      attributes["need_cleanup"] = false;
      attributes["num_frontier_voxels"] = 0;
      addNode(idOfPlace(i), placeLayer, std::move(attributes));
      if (tree_.areaOfNode[i] >= 0) addEdge(idOf('R', tree_.areaOfNode[i]), idOfPlace(i));
    }
    for (const auto& [a, b] : linksOf(map))
      addEdge(idOfPlace(a), idOfPlace(b),
              distanceBetween(*tree_.places[a].position, *tree_.places[b].position));
  }

  void addRooms() {
    // Rooms have their middle on the floor; the height of the places is as good as any.
    double height = 0;
    for (const Place& place : tree_.places)
      height += (axes_.t() * cv::Vec3d(place.position->data()))[2] / static_cast<double>(tree_.places.size());
    cv::Vec3d middle;
    for (const WorldArea& area : world_.areas) {
      const cv::Vec3d at = axes_ * cv::Vec3d(area.center.x, area.center.y, height);
      middle += at / static_cast<double>(world_.areas.size());
      Json attributes = attributesOf("RoomNodeAttributes", area.displayName(), at, 0);
      attributes["semantic_class_probabilities"] = Json::object();
      addNode(idOf('R', area.id), roomLayer, std::move(attributes));
      addEdge(idOf('B', 0), idOf('R', area.id));
    }
    addNode(idOf('B', 0), buildingLayer, attributesOf("SemanticNodeAttributes", "building", middle, 0));
    for (const auto& [a, b] : tree_.neighbors) addEdge(idOf('R', a), idOf('R', b));
  }

  void addNode(std::uint64_t id, Layer layer, Json attributes) {
    nodes_.push_back({{"id", id}, {"layer", static_cast<int>(layer)}, {"attributes", std::move(attributes)}});
  }

  /// `weight` < 0: none.
  void addEdge(std::uint64_t source, std::uint64_t target, double weight = -1) {
    edges_.push_back(
        {{"source", source},
         {"target", target},
         {"info",
          {{"type", "EdgeAttributes"}, {"weighted", weight >= 0}, {"weight", weight >= 0 ? weight : 1.0}}}});
  }

  const WorldMap& world_;
  LayerTree tree_;
  cv::Matx33d axes_ = cv::Matx33d::eye();
  Json nodes_ = Json::array(), edges_ = Json::array(), labels_ = Json::object();
};

/// The JSON of Spark-DSG's encoding 1.0.3, which 1.0.3 to 1.1 read (`spark_dsg.DynamicSceneGraph.load`):
/// layers objects (2, ids O…), places (3, p…), rooms (4, R…) and one building (5, B0); edges between places
/// that are linked (weight: meters), areas whose places are, objects that stand on each other, and each thing
/// and the one that holds it (LayerTree). semantic_label is the best word's number in the vocabulary, and
/// that is in metadata. Throws Error (insufficientData) where a place has no position.
Json sparkDsgJson(const WorldMap& world) {
  return SceneGraph(world).json();
}

using Json = nlohmann::ordered_json;
using exporting::data;
using exporting::rounded;

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
                          {"version", 1},
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
