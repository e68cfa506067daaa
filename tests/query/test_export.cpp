// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>

#include "estancia/query/export.hpp"
#include "map_file/sample_map.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using nlohmann::json;
using test::FailsWith;

std::size_t countOf(const std::string& text, const std::string& pattern) {
  const std::regex expression(pattern);
  return static_cast<std::size_t>(
      std::distance(std::sregex_iterator(text.begin(), text.end(), expression), {}));
}

/// The text of a GraphML element's data.
std::string dataOf(const std::string& xml, const std::string& element, const std::string& key) {
  const std::size_t start = xml.find("<" + element + ">");
  const std::string body = xml.substr(start, xml.find("\n    </", start) - start);
  const std::string tag = "<data key=\"" + key + "\">";
  const std::size_t value = body.find(tag);
  return value == std::string::npos
             ? "(none)"
             : body.substr(value + tag.size(), body.find("</data>", value) - value - tag.size());
}

/// A map whose every text tries to break out of its place.
TopologicalMap hostileMap() {
  TopologicalMap map = test::sampleMap();
  map.vocabulary = Vocabulary({"a<b>&\"c\"", "]]>", "\xff\xfe", "tab\there", "\x01"});
  map.model = "mo\"del\xff";
  for (MappedFrame& frame : map.frames) frame.room = "R&D <\"lab\">\x02\xc3";
  return map;
}

/// Checks with xmllint where there is one; a full parser is not worth a dependency.
void expectWellFormed(const std::string& xml) {
  if (std::system("command -v xmllint >/dev/null 2>&1") != 0) return;
  const test::ScratchFolder folder;
  test::writeFile(folder / "map.graphml", xml);
  EXPECT_EQ(std::system(("xmllint --noout --nonet '" + (folder / "map.graphml").string() + "'").c_str()), 0);
}

TEST(Graphml, HoldsNodesEdgesAndTheirAttributes) {
  const std::string xml = exportMap(test::sampleMap(), "graphml");
  expectWellFormed(xml);
  EXPECT_EQ(countOf(xml, "<node id=\"n[0-9]+\">"), 3U);
  EXPECT_EQ(countOf(xml, "<edge source=\"n[0-9]+\" target=\"n[0-9]+\">"), 3U);
  const std::string office = "node id=\"n3\"";
  EXPECT_EQ(dataOf(xml, office, "words"), "desk, coffee mug, dining table, cup, umbrella");
  EXPECT_EQ(dataOf(xml, office, "room"), "office");
  EXPECT_EQ(std::stod(dataOf(xml, office, "x")), 8);
  EXPECT_EQ(dataOf(xml, office, "y"), "0.5");
  EXPECT_EQ(dataOf(xml, office, "frames"), "2");
  EXPECT_EQ(dataOf(xml, "edge source=\"n3\" target=\"n1\"", "count"), "1");
  // every key that is used is declared
  for (const char* key : {"words", "room", "x", "y", "z", "frames", "count"})
    EXPECT_EQ(countOf(xml, std::string("<key id=\"") + key + "\" "), 1U) << key;
}

TEST(Graphml, EscapesHostileTextsAndLeavesOutWhatIsNotKnown) {
  TopologicalMap map = hostileMap();
  std::string xml = exportMap(map, "graphml");
  expectWellFormed(xml);
  EXPECT_EQ(dataOf(xml, "node id=\"n0\"", "words").substr(0, 28), "a&lt;b&gt;&amp;&quot;c&quot;");
  EXPECT_EQ(xml.find('\x01'), std::string::npos);
  for (MappedFrame& frame : map.frames) {
    frame.pose.reset();
    frame.room.clear();
  }
  xml = exportMap(map, "graphml");
  expectWellFormed(xml);
  EXPECT_EQ(countOf(xml, "<data key=\"(x|y|z|room)\">"), 0U);
}

TEST(PlacesJson, HoldsPlacesAndWords) {
  ExportOptions two;
  two.maxWords = 2;
  const TopologicalMap map = test::sampleMap();
  const json parsed = json::parse(exportMap(map, "json", two));
  EXPECT_EQ(parsed.at("format"), "estancia-places");
  EXPECT_EQ(parsed.at("version"), 1);
  EXPECT_EQ(parsed.at("vocabulary"), map.vocabulary.digest());
  ASSERT_EQ(parsed.at("places").size(), 3U);
  const json& office = parsed["places"][2];
  EXPECT_EQ(office.at("id"), 3);
  EXPECT_EQ(office.at("room"), "office");
  EXPECT_EQ(office.at("position"), json({8.0, 0.5, 0.0}));
  EXPECT_EQ(office.at("frames"), 2);
  EXPECT_EQ(office.at("frame_ranges"), json::parse("[[4, 5]]"));
  EXPECT_EQ(parsed["places"][1].at("frame_ranges"), json::parse("[[2, 3], [6, 6]]")) << "visited twice";
  ASSERT_EQ(office.at("words").size(), 2U);
  EXPECT_EQ(office["words"][0].at("label"), "desk");
  EXPECT_NEAR(office["words"][0].at("p").get<double>(), 0.75, 1e-6);
  ASSERT_EQ(parsed.at("transitions").size(), 3U);
  EXPECT_EQ(parsed["transitions"][1], json({{"from", 1}, {"to", 3}, {"count", 1}}));
}

TEST(PlacesJson, GivesNullForWhatIsNotKnownAndStaysValid) {
  TopologicalMap map = hostileMap();
  map.frames.clear();
  const json parsed = json::parse(exportMap(map, "json"));
  EXPECT_TRUE(parsed["places"][0].at("room").is_null());
  EXPECT_TRUE(parsed["places"][0].at("position").is_null());
}

/// What Nav2's GeoJsonGraphFileLoader demands.
void expectNav2Loads(const json& graph) {
  std::set<unsigned> ids, nodes;
  std::size_t edges = 0;
  for (const json& feature : graph.at("features")) {
    const json& properties = feature.at("properties");
    EXPECT_TRUE(ids.insert(properties.at("id").get<unsigned>()).second) << "an id is used twice";
    if (feature.at("geometry").at("type") == "Point") {
      nodes.insert(properties.at("id").get<unsigned>());
      EXPECT_TRUE(properties.at("frame").is_string());
      EXPECT_EQ(feature["geometry"].at("coordinates").size(), 2U);
      for (const auto& [key, value] : properties.at("metadata").items())
        for (const json& item : value.is_array() ? value : json::array({value}))
          EXPECT_TRUE(item.is_number() || item.is_string() || item.is_boolean()) << key;
    } else {
      EXPECT_EQ(feature["geometry"]["type"], "MultiLineString");
      EXPECT_TRUE(nodes.contains(properties.at("startid").get<unsigned>()));
      EXPECT_TRUE(nodes.contains(properties.at("endid").get<unsigned>()));
      EXPECT_GE(properties.at("cost").get<float>(), 0);
      EXPECT_TRUE(properties.at("overridable").get<bool>());
      ++edges;
    }
  }
  EXPECT_FALSE(nodes.empty());
  EXPECT_GT(edges, 0U);
}

TEST(Nav2, IsARouteGraphWithWords) {
  const json graph = json::parse(exportMap(test::sampleMap(), "nav2"));
  EXPECT_EQ(graph.at("type"), "FeatureCollection");
  expectNav2Loads(graph);
  ASSERT_EQ(graph["features"].size(), 3U + 4U) << "every link can be driven both ways";
  const json& office = graph["features"][2]["properties"];
  EXPECT_EQ(office["id"], 3);
  EXPECT_EQ(office["frame"], "map");
  EXPECT_EQ(office["metadata"]["class"], "office");
  EXPECT_EQ(office["metadata"]["labels"][0], "desk");
  const json& edge = graph["features"][3];
  EXPECT_EQ(edge["properties"]["startid"], 0);
  EXPECT_EQ(edge["properties"]["endid"], 1);
  EXPECT_NEAR(edge["properties"]["cost"].get<double>(), std::hypot(4, 0.5), 1e-6);
  EXPECT_EQ(edge["geometry"]["coordinates"], json::parse("[[[0.0, 0.5], [4.0, 0.0]]]"));
}

TEST(Nav2, KeepsToDrivenDirectionsAndNamesPlacesByLabelsWhereNoRoomIsKnown) {
  ExportOptions options;
  options.bidirectional = false;
  options.frame = "odom";
  TopologicalMap map = test::sampleMap();
  for (MappedFrame& frame : map.frames) frame.room.clear();
  const json graph = json::parse(exportMap(map, "nav2", options));
  expectNav2Loads(graph);
  EXPECT_EQ(graph["features"].size(), 3U + 3U);
  EXPECT_EQ(graph["features"][0]["properties"]["frame"], "odom");
  EXPECT_EQ(graph["features"][2]["properties"]["metadata"]["class"], "desk");
  expectNav2Loads(json::parse(exportMap(hostileMap(), "nav2")));
}

TEST(Nav2, NeedsPositionsAndTransitions) {
  TopologicalMap map = test::sampleMap();
  map.frames[0].pose.reset();
  EXPECT_NO_THROW(exportMap(map, "nav2")) << "one posed frame a node is enough";
  map.frames[1].pose.reset();
  EXPECT_THAT([&] { exportMap(map, "nav2"); }, FailsWith(ErrorCode::insufficientData));
  for (int id = 10; id < 20; ++id) map.nodes.push_back(test::nodeWith(id, 1, map.nodes[0].mean));
  EXPECT_THAT([&] { exportMap(map, "nav2"); }, FailsWith(ErrorCode::insufficientData));
  map = test::sampleMap();
  map.transitions.clear();
  EXPECT_THAT([&] { exportMap(map, "nav2"); }, FailsWith(ErrorCode::insufficientData));
}

TEST(Export, WritesEveryFormatByName) {
  const test::ScratchFolder folder;
  for (const auto& [format, explanation] : exportFormats()) {
    exportMap(test::sampleMap(), format, folder / format);
    EXPECT_EQ(test::readFile(folder / format), exportMap(test::sampleMap(), format)) << explanation;
  }
  EXPECT_THAT([&] { exportMap(test::sampleMap(), "dot", folder / "dot"); },
              FailsWith(ErrorCode::unknownName));
  EXPECT_FALSE(std::filesystem::exists(folder / "dot"));
}

}  // namespace
}  // namespace estancia
