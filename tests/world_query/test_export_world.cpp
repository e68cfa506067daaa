// Areas and objects for other programs: each format against what its readers demand.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/world_query/export_world.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>

#include "support/errors.hpp"
#include "support/sample_world.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using nlohmann::json;
using test::FailsWith;
using test::hostileName;
using test::sampleWorld;
using testing::UnorderedElementsAre;

WorldMap onlyPlaces() {
  WorldMap world{.places = test::samplePlaces()};
  world.areaOfFrame.assign(world.places.frames.size(), -1);
  return world;
}

/// Names as hostile as a caller of the library can make them.
WorldMap hostileWorld() {
  WorldMap world = sampleWorld();
  world.areas[0].givenName = "<a href=\"x\">&amp;]]>\x01\xff";
  world.objects[0].givenName = "\"}],\n\\\x1b[2J";
  world.places.vocabulary = Vocabulary({"coffee mug", "cup, mug", "umbrella", "<&\">", "bathtub", "]]>\x02"});
  return world;
}

void expectNoNumberIsLost(const json& value) {
  if (value.is_structured())
    for (const json& part : value) expectNoNumberIsLost(part);
  EXPECT_FALSE(value.is_number_float() && !std::isfinite(value.get<double>()));
}

TEST(ExportWorld, OfPlacesAloneIsThatOfTheMapAndHostileNamesBreakNoFormat) {
  for (const auto& [format, explanation] : exportFormats())
    EXPECT_EQ(exportWorld(onlyPlaces(), format), exportMap(test::samplePlaces(), format)) << explanation;
  EXPECT_THAT([] { exportWorld(onlyPlaces(), "rooms"); }, FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT([] { exportWorld(onlyPlaces(), "dot"); }, FailsWith(ErrorCode::unknownName));
  for (const auto& [format, explanation] : worldFormats()) {
    const std::string text = exportWorld(hostileWorld(), format);
    EXPECT_FALSE(text.empty());
    if (format != "graphml") expectNoNumberIsLost(json::parse(text));
  }
}

TEST(RoomsJson, HoldsAreasPlacesAndObjects) {
  ExportOptions one;
  one.maxWords = 1;
  const json rooms = json::parse(exportWorld(sampleWorld(), "rooms", one));
  EXPECT_EQ(rooms["format"], "estancia-rooms");
  ASSERT_EQ(rooms["rooms"].size(), 4U);
  const json& kitchen = rooms["rooms"][0];
  EXPECT_EQ(kitchen["name"], "kitchen");
  EXPECT_EQ(kitchen["neighbors"], json({1, 2}));
  EXPECT_EQ(kitchen["outline"].size(), 4U);
  ASSERT_EQ(kitchen["places"].size(), 1U);
  EXPECT_EQ(kitchen["places"][0]["words"].size(), 1U);
  const json& objects = kitchen["places"][0]["objects"];
  ASSERT_EQ(objects.size(), 2U);
  EXPECT_EQ(objects[1]["name"], "coffee mug");
  EXPECT_EQ(objects[1]["on"]["id"], 0);
  EXPECT_EQ(objects[1]["words"].size(), 1U);
  EXPECT_EQ(rooms["rooms"][3]["name"], "Ana's \"room\"");
  EXPECT_EQ(rooms["rooms"][3]["places"][0]["objects"][2]["given_name"], hostileName);
  EXPECT_EQ(rooms["elsewhere"]["places"].size(), 0U);
}

TEST(Nav2World, HasPointsOnlyForNodes) {
  const json graph = json::parse(exportWorld(sampleWorld(), "nav2"));
  std::map<std::string, int> kinds;
  std::set<int> ids;
  for (const json& feature : graph["features"]) {
    ++kinds[feature["geometry"]["type"]];
    EXPECT_TRUE(ids.insert(feature["properties"]["id"].get<int>()).second);
    if (!feature["properties"].contains("metadata")) continue;
    for (const auto& [key, value] : feature["properties"]["metadata"].items())
      for (const json& item : value.is_array() ? value : json::array({value}))
        EXPECT_TRUE(item.is_number() || item.is_string() || item.is_boolean()) << key;
    if (feature["geometry"]["type"] == "Polygon") {
      const json& ring = feature["geometry"]["coordinates"][0];
      EXPECT_GE(ring.size(), 4U);
      EXPECT_EQ(ring.front(), ring.back());
    }
  }
  EXPECT_EQ(kinds, (std::map<std::string, int>{
                       {"Point", 4}, {"MultiLineString", 8}, {"Polygon", 4}, {"MultiPoint", 6}}));
  const json& kitchen = graph["features"][0]["properties"]["metadata"];
  EXPECT_EQ(kitchen["area"], "kitchen");
  EXPECT_EQ(kitchen["objects"], json({"dining table", "coffee mug"}));
  const json& chair = graph["features"][4 + 8 + 4 + 4];
  EXPECT_EQ(chair["properties"]["metadata"]["name"], hostileName);
  EXPECT_EQ(chair["geometry"]["coordinates"], json::parse("[[8.0, 6.0]]"));
}

std::size_t countOf(const std::string& text, const std::string& pattern) {
  const std::regex expression(pattern);
  return static_cast<std::size_t>(
      std::distance(std::sregex_iterator(text.begin(), text.end(), expression), {}));
}

TEST(GraphmlWorld, HoldsAreasAndObjectsAsNodes) {
  for (const WorldMap& world : {sampleWorld(), hostileWorld()}) {
    const std::string xml = exportWorld(world, "graphml");
    EXPECT_EQ(countOf(xml, "<node id=\"n[0-9]+\">"), 4U);
    EXPECT_EQ(countOf(xml, "<node id=\"a[0-9]+\">"), 4U);
    EXPECT_EQ(countOf(xml, "<node id=\"o[0-9]+\">"), 6U);
    EXPECT_EQ(countOf(xml, "<data key=\"relation\">in<"), 4U + 6U);
    EXPECT_EQ(countOf(xml, "<data key=\"relation\">at<"), 6U);
    EXPECT_EQ(countOf(xml, "<edge source=\"o1\" target=\"o0\">\n      <data key=\"relation\">on<"), 1U);
    const std::regex used("<data key=\"([a-z_]+)\">");
    for (std::sregex_iterator key(xml.begin(), xml.end(), used), end; key != end; ++key)
      EXPECT_EQ(countOf(xml, "<key id=\"" + key->str(1) + "\" "), 1U) << key->str(1);
    if (std::system("command -v xmllint >/dev/null 2>&1") != 0) continue;
    const test::ScratchFolder folder;
    test::writeFile(folder / "map.graphml", xml);
    EXPECT_EQ(std::system(("xmllint --noout --nonet '" + (folder / "map.graphml").string() + "'").c_str()),
              0);
  }
}

// ---- Spark-DSG: what its reader takes (graph_json_serialization.cpp, serialization_info() of the
// attributes)

std::vector<std::string> keysOf(const json& object) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : object.items()) keys.push_back(key);
  return keys;
}

void expectQuaternion(const json& q) {
  EXPECT_THAT(keysOf(q), UnorderedElementsAre("w", "x", "y", "z"));
  double square = 0;
  for (const json& part : q) square += part.get<double>() * part.get<double>();
  EXPECT_NEAR(square, 1, 1e-9);
}

void expectVector(const json& v) {
  ASSERT_TRUE(v.is_array());
  ASSERT_EQ(v.size(), 3U);
  for (const json& part : v) EXPECT_TRUE(part.is_number());
}

void expectSemanticAttributes(const json& attributes) {
  expectVector(attributes.at("position"));
  EXPECT_TRUE(attributes.at("last_update_time_ns").is_number_unsigned());
  EXPECT_TRUE(attributes.at("is_active").is_boolean());
  EXPECT_TRUE(attributes.at("is_predicted").is_boolean());
  EXPECT_TRUE(attributes.at("name").is_string());
  for (const char* channel : {"r", "g", "b", "a"})
    EXPECT_LE(attributes.at("color").at(channel).get<unsigned>(), 255U);
  EXPECT_LE(attributes.at("semantic_label").get<std::uint64_t>(), 0xFFFFFFFFU);
  EXPECT_THAT(keysOf(attributes.at("semantic_feature")), UnorderedElementsAre("rows", "cols", "data"));
  const json& box = attributes.at("bounding_box");
  EXPECT_THAT(box.at("type").get<std::string>(), testing::AnyOf("INVALID", "AABB", "RAABB", "OBB"));
  expectVector(box.at("dimensions"));
  expectVector(box.at("world_P_center"));
  expectQuaternion(box.at("world_R_center"));
}

void expectAttributes(const json& attributes, int layer) {
  expectSemanticAttributes(attributes);
  std::vector<std::string> keys{
      "type", "position", "last_update_time_ns", "is_active",      "is_predicted",
      "name", "color",    "bounding_box",        "semantic_label", "semantic_feature"};
  const auto alsoHas = [&keys](std::initializer_list<const char*> more) {
    keys.insert(keys.end(), more.begin(), more.end());
  };
  if (layer == 2) {
    EXPECT_EQ(attributes.at("type"), "ObjectNodeAttributes");
    alsoHas({"mesh_connections", "registered", "world_R_object"});
    expectQuaternion(attributes.at("world_R_object"));
  } else if (layer == 3) {
    EXPECT_EQ(attributes.at("type"), "PlaceNodeAttributes");
    alsoHas({"distance", "num_basis_points", "voxblox_mesh_connections", "pcl_mesh_connections",
             "mesh_vertex_labels", "deformation_connections", "real_place", "active_frontier",
             "frontier_scale", "orientation", "need_cleanup", "num_frontier_voxels"});
    expectVector(attributes.at("frontier_scale"));
    expectQuaternion(attributes.at("orientation"));
  } else if (layer == 4) {
    EXPECT_EQ(attributes.at("type"), "RoomNodeAttributes");
    alsoHas({"semantic_class_probabilities"});
    EXPECT_TRUE(attributes.at("semantic_class_probabilities").is_object());
  } else {
    EXPECT_EQ(attributes.at("type"), "SemanticNodeAttributes");
  }
  EXPECT_THAT(keysOf(attributes), testing::UnorderedElementsAreArray(keys));
}

/// Layers of the nodes, by id. Checks that the graph has the fields that are read, and one parent a node.
std::map<std::uint64_t, int> expectSparkDsgLoads(const json& graph) {
  EXPECT_EQ(graph.at("SPARK_DSG_header"),
            json::parse(R"({"project_name": "main", "version": {"major": 1, "minor": 0, "patch": 3}})"));
  EXPECT_EQ(graph.at("layer_ids"), json({2, 3, 4, 5}));
  EXPECT_TRUE(graph.at("metadata").is_object());
  const std::map<int, char> letters{{2, 'O'}, {3, 'p'}, {4, 'R'}, {5, 'B'}};
  std::map<std::uint64_t, int> layers;
  for (const json& node : graph.at("nodes")) {
    const auto id = node.at("id").get<std::uint64_t>();
    const int layer = node.at("layer").get<int>();
    EXPECT_EQ(static_cast<char>(id >> 56U), letters.at(layer));
    EXPECT_TRUE(layers.emplace(id, layer).second) << "an id is used twice";
    expectAttributes(node.at("attributes"), layer);
  }
  std::set<std::pair<std::uint64_t, std::uint64_t>> edges;
  std::map<std::uint64_t, int> parents;
  for (const json& edge : graph.at("edges")) {
    const auto source = edge.at("source").get<std::uint64_t>(),
               target = edge.at("target").get<std::uint64_t>();
    EXPECT_TRUE(edges.insert(std::minmax(source, target)).second);
    EXPECT_EQ(edge.at("info").at("type"), "EdgeAttributes");
    EXPECT_TRUE(edge["info"].at("weighted").is_boolean());
    EXPECT_GE(edge["info"].at("weight").get<double>(), 0);
    const int above = layers.at(source), below = layers.at(target);
    EXPECT_TRUE(above == below || above == below + 1);
    if (above != below) {
      EXPECT_EQ(++parents[target], 1);
    }
  }
  return layers;
}

TEST(SparkDsg, HasTheFieldsThatItsReaderTakes) {
  const json graph = json::parse(exportWorld(sampleWorld(), "spark-dsg"));
  std::map<int, int> counts;
  for (const auto& [id, layer] : expectSparkDsgLoads(graph)) ++counts[layer];
  EXPECT_EQ(counts, (std::map<int, int>{{2, 6}, {3, 4}, {4, 4}, {5, 1}}));
  // 6 objects and 4 places and 4 rooms have parents; 4 links, 4 neighbors, 1 mug on a table
  EXPECT_EQ(graph["edges"].size(), 6U + 4U + 4U + 4U + 4U + 1U);
  const json& table = graph["nodes"][0];
  EXPECT_EQ(table["id"].get<std::uint64_t>(), 0x4F00000000000000U);
  EXPECT_EQ(table["attributes"]["name"], "dining table");
  EXPECT_EQ(table["attributes"]["semantic_label"], 3);
  EXPECT_EQ(graph["metadata"]["labels"]["3"], "dining table");
  EXPECT_EQ(table["attributes"]["bounding_box"]["type"], "RAABB");
  EXPECT_EQ(table["attributes"]["bounding_box"]["dimensions"], json({1.6, 0.9, 0.75}));
  EXPECT_NEAR(table["attributes"]["bounding_box"]["world_R_center"]["z"].get<double>(), std::sqrt(0.5), 1e-9);
  EXPECT_EQ(table["attributes"]["last_update_time_ns"], 500000000);
  EXPECT_EQ(graph["nodes"][4]["attributes"]["name"], hostileName);
  EXPECT_EQ(graph["nodes"][5]["attributes"]["bounding_box"]["type"], "INVALID") << "of no size";
  EXPECT_EQ(graph["nodes"][5]["attributes"]["semantic_label"], 0xFFFFFFFFU);
}

TEST(SparkDsg, LaysATiltedFloorIntoTheMap) {
  WorldMap world = sampleWorld();
  world.plan->floor = Floor(cv::Vec3d(0, -1, 0));  // axes of a camera's map
  const json graph = json::parse(exportWorld(world, "spark-dsg"));
  expectSparkDsgLoads(graph);
  EXPECT_EQ(graph["nodes"][0]["attributes"]["bounding_box"]["type"], "OBB");
  for (const json& node : graph["nodes"]) {
    if (node["layer"] != 4) continue;
    const auto at = node["attributes"]["position"].get<std::array<double, 3>>();
    const WorldArea& area = world.areas[node["id"].get<std::uint64_t>() & 0xFFU];
    const cv::Point2d onFloor = world.plan->floor.position({at[0], at[1], at[2]});
    EXPECT_NEAR(onFloor.x, area.center.x, 1e-9);
    EXPECT_NEAR(onFloor.y, area.center.y, 1e-9);
  }
}

TEST(SparkDsg, NeedsPositionsOnly) {
  expectSparkDsgLoads(json::parse(exportWorld(hostileWorld(), "spark-dsg")));
  EXPECT_EQ(expectSparkDsgLoads(json::parse(exportWorld(onlyPlaces(), "spark-dsg"))).size(), 4U);
  WorldMap world = sampleWorld();
  world.places.frames[7].pose.reset();
  EXPECT_THAT([&] { exportWorld(world, "spark-dsg"); }, FailsWith(ErrorCode::insufficientData));
}

TEST(ExportWorld, ObjectsInNoAreaAreAtThePlaceThatSawThemBestAndKnownOnesHaveTheirPoses) {
  WorldMap world = sampleWorld();
  world.objects[1].area = -1;
  world.objects[1].known = KnownPose{"Ana's mug", 0.9, Pose::planar(1, 2, 0)};
  for (const auto& [format, explanation] : worldFormats()) {
    const std::string text = exportWorld(world, format);
    if (format != "graphml") expectNoNumberIsLost(json::parse(text));
  }
  const json rooms = json::parse(exportWorld(world, "rooms"));
  EXPECT_EQ(rooms["rooms"][0]["places"][0]["objects"].size(), 2U);
  const json graph = json::parse(exportWorld(world, "nav2"));
  const json& mug = graph["features"][4 + 8 + 4 + 1]["properties"]["metadata"];
  EXPECT_EQ(mug["known"]["name"], "Ana's mug");
  EXPECT_EQ(mug["known"]["position"], json({1.0, 2.0, 0.0}));
  EXPECT_FALSE(mug.contains("area_id"));
  world.areaOfFrame.assign(world.places.frames.size(), -1);
  EXPECT_EQ(json::parse(exportWorld(world, "rooms"))["elsewhere"]["places"].size(), 4U);
}

}  // namespace
}  // namespace estancia
