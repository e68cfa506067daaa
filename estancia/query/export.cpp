// SPDX-License-Identifier: Apache-2.0
#include "estancia/query/export.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "estancia/core/fail.hpp"
#include "estancia/core/label_words.hpp"
#include "estancia/core/output_file.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/map_file/places.hpp"
#include "estancia/query/export_text.hpp"

namespace estancia {

namespace exporting {
namespace {

std::string escapeXml(std::string_view text) {
  constexpr std::string_view special = "&<>\"";
  constexpr std::array<const char*, special.size()> names{"&amp;", "&lt;", "&gt;", "&quot;"};
  std::string result;
  for (const char c : printable(text))
    if (const std::size_t i = special.find(c); i != special.npos)
      result += names[i];
    else
      result += c;
  return result;
}

}  // namespace

std::string dump(const nlohmann::ordered_json& json) {
  // Names come from file systems and may be no UTF-8.
  return json.dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

double rounded(double probability) {
  return std::round(probability * 1e6) / 1e6;
}

double rounded(float probability) {
  return rounded(static_cast<double>(probability));
}

std::vector<std::string> bestWords(const TopologicalMap& map, const Node& node, std::size_t count) {
  std::vector<std::string> words;
  for (const std::size_t label : bestLabels(node, count)) words.push_back(shortLabel(map.vocabulary[label]));
  return words;
}

std::vector<nlohmann::ordered_json> frameRanges(const TopologicalMap& map) {
  std::vector<nlohmann::ordered_json> ranges(map.nodes.size(), nlohmann::ordered_json::array());
  for (const Visit& visit : visitsOf(map))
    if (const std::size_t i = indexOf(map, visit.node); i < ranges.size())
      ranges[i].push_back({visit.firstFrame, visit.lastFrame});
  return ranges;
}

std::string data(const char* key, std::string_view value) {
  return fmt::format("      <data key=\"{}\">{}</data>\n", key, escapeXml(value));
}

}  // namespace exporting

namespace {

using Json = nlohmann::ordered_json;
using exporting::bestWords;
using exporting::data;
using exporting::dump;
using exporting::rounded;

constexpr int formatVersion = 1;

/// Attributes of an element in GraphML, in the order of declaration.
struct Attribute {
  const char* name;
  const char* element;
  const char* type;
};
constexpr Attribute attributes[] = {{"words", "node", "string"},
                                    {"room", "node", "string"},
                                    {"predicted_room", "node", "string"},
                                    {"room_probability", "node", "double"},
                                    {"x", "node", "double"},
                                    {"y", "node", "double"},
                                    {"z", "node", "double"},
                                    {"frames", "node", "long"},
                                    {"count", "edge", "long"}};

Json pointFeature(const TopologicalMap& map, const Node& node, const Place& place,
                  const ExportOptions& options) {
  const std::vector<std::size_t> best = bestLabels(node, options.maxWords);
  Json labels = Json::array(), probabilities = Json::array();
  for (const std::size_t label : best) {
    labels.push_back(shortLabel(map.vocabulary[label]));
    probabilities.push_back(rounded(node.mean[label]));
  }
  // Nav2's loader knows numbers, texts, truth values and lists of these; null makes it fail.
  Json metadata;
  metadata["class"] = !place.room.empty() ? place.room
                      : place.predictedRoom() != nullptr
                          ? place.predictedRoom()->room
                          : shortLabel(map.vocabulary[bestLabels(node, 1).at(0)]);
  if (!place.room.empty()) metadata["room"] = place.room;
  if (const RoomProbability* predicted = place.predictedRoom()) {
    metadata["predicted_room"] = predicted->room;
    metadata["room_probability"] = rounded(predicted->probability);
  }
  metadata["labels"] = labels;
  metadata["probabilities"] = probabilities;
  metadata["frames"] = node.frames;
  return {{"type", "Feature"},
          {"properties", {{"id", node.id}, {"frame", options.frame}, {"metadata", metadata}}},
          {"geometry", {{"type", "Point"}, {"coordinates", {(*place.position)[0], (*place.position)[1]}}}}};
}

Json lineFeature(int id, int from, int to, const Position& start, const Position& end) {
  const Json points = Json::array({Json::array({start[0], start[1]}), Json::array({end[0], end[1]})});
  return {{"type", "Feature"},
          {"properties",
           {{"id", id},
            {"startid", from},
            {"endid", to},
            {"cost", distanceBetween(start, end)},
            {"overridable", true}}},
          {"geometry", {{"type", "MultiLineString"}, {"coordinates", Json::array({points})}}}};
}

void requireRouteGraph(const TopologicalMap& map, const std::vector<Place>& places) {
  std::vector<int> lost;
  for (std::size_t i = 0; i < places.size(); ++i)
    if (!places[i].position) lost.push_back(map.nodes[i].id);
  constexpr std::size_t shown = 10;
  const bool cut = lost.size() > shown;
  const std::size_t count = lost.size();
  if (cut) lost.resize(shown);
  if (count > 0)
    fail(ErrorCode::insufficientData,
         "{} of the map's {} nodes have no position ({}{}), which Nav2 needs; map the sequence "
         "with its poses",
         count, map.nodes.size(), fmt::join(lost, " "), cut ? " …" : "");
  if (linksOf(map).empty())
    throw Error(ErrorCode::insufficientData,
                "the map has no transitions, and Nav2 refuses graphs without edges; map a longer drive");
}

std::string toGraphml(const TopologicalMap& map, const ExportOptions& options) {
  const std::vector<Place> places = placesOf(map);
  std::string text =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<graphml xmlns=\"http://graphml.graphdrawing.org/xmlns\" "
      "xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" "
      "xsi:schemaLocation=\"http://graphml.graphdrawing.org/xmlns "
      "http://graphml.graphdrawing.org/xmlns/1.0/graphml.xsd\">\n";
  text += fmt::format("  <desc>Estancia map, format {}, vocabulary {}</desc>\n", formatVersion,
                      map.vocabulary.digest());
  for (const Attribute& attribute : attributes)
    text += fmt::format("  <key id=\"{0}\" for=\"{1}\" attr.name=\"{0}\" attr.type=\"{2}\"/>\n",
                        attribute.name, attribute.element, attribute.type);
  text += "  <graph id=\"map\" edgedefault=\"directed\">\n";
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Node& node = map.nodes[i];
    text += fmt::format("    <node id=\"n{}\">\n", node.id);
    text += data("words", fmt::format("{}", fmt::join(bestWords(map, node, options.maxWords), ", ")));
    if (!places[i].room.empty()) text += data("room", places[i].room);
    if (const RoomProbability* predicted = places[i].predictedRoom()) {
      text += data("predicted_room", predicted->room);
      text += data("room_probability", fmt::format("{}", rounded(predicted->probability)));
    }
    if (const auto& position = places[i].position) {
      text += data("x", fmt::format("{}", (*position)[0]));
      text += data("y", fmt::format("{}", (*position)[1]));
      text += data("z", fmt::format("{}", (*position)[2]));
    }
    text += data("frames", std::to_string(node.frames)) + "    </node>\n";
  }
  for (const Transition& transition : map.transitions)
    text += fmt::format("    <edge source=\"n{}\" target=\"n{}\">\n{}    </edge>\n", transition.from,
                        transition.to, data("count", std::to_string(transition.count)));
  return text + "  </graph>\n</graphml>\n";
}

std::string toPlacesJson(const TopologicalMap& map, const ExportOptions& options) {
  const std::vector<Place> places = placesOf(map);
  Json json{
      {"format", "estancia-places"}, {"version", formatVersion}, {"vocabulary", map.vocabulary.digest()},
      {"model", map.model},          {"distance", map.distance}, {"places", Json::array()},
      {"transitions", Json::array()}};
  std::vector<Json> ranges = exporting::frameRanges(map);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Node& node = map.nodes[i];
    Json words = Json::array();
    for (const std::size_t label : bestLabels(node, options.maxWords))
      words.push_back({{"label", map.vocabulary[label]}, {"p", rounded(node.mean[label])}});
    Json place{{"id", node.id},       {"words", words},        {"room", nullptr},
               {"position", nullptr}, {"frames", node.frames}, {"frame_ranges", std::move(ranges[i])}};
    if (!places[i].room.empty()) place["room"] = places[i].room;
    for (const RoomProbability& room : places[i].predicted)
      place["predicted_rooms"].push_back({{"room", room.room}, {"p", rounded(room.probability)}});
    if (places[i].position) place["position"] = *places[i].position;
    json["places"].push_back(std::move(place));
  }
  for (const Transition& transition : map.transitions)
    json["transitions"].push_back(
        {{"from", transition.from}, {"to", transition.to}, {"count", transition.count}});
  return dump(json);
}

std::string toNav2(const TopologicalMap& map, const ExportOptions& options) {
  const std::vector<Place> places = placesOf(map);
  requireRouteGraph(map, places);
  Json features = Json::array();
  for (std::size_t i = 0; i < places.size(); ++i)
    features.push_back(pointFeature(map, map.nodes[i], places[i], options));
  std::set<std::pair<std::size_t, std::size_t>> edges;
  for (const Transition& transition : map.transitions) {
    const std::size_t a = indexOf(map, transition.from), b = indexOf(map, transition.to);
    if (a == b || a == places.size() || b == places.size()) continue;
    edges.emplace(a, b);
    if (options.bidirectional) edges.emplace(b, a);
  }
  int id = map.nodes.back().id;  // ids are unique among nodes and edges together
  for (const auto& [a, b] : edges)
    features.push_back(
        lineFeature(++id, map.nodes[a].id, map.nodes[b].id, *places[a].position, *places[b].position));
  return dump({{"type", "FeatureCollection"},
               {"name", "graph"},
               {"crs", {{"type", "name"}, {"properties", {{"name", "urn:ogc:def:crs:EPSG::3857"}}}}},
               {"estancia", {{"version", formatVersion}, {"vocabulary", map.vocabulary.digest()}}},
               {"features", features}});
}

struct Format {
  const char *name, *explanation;
  std::string (*write)(const TopologicalMap&, const ExportOptions&);
};
constexpr Format formats[] = {
    {"graphml", "for graph programs (Gephi, yEd, NetworkX …)", toGraphml},
    {"json", "places, their words and the numbers of their frames, as simple JSON", toPlacesJson},
    {"nav2", "GeoJSON for the route server of Nav2; needs poses", toNav2}};

}  // namespace

OptionGroup declare(ExportOptions& options) {
  OptionGroup group("export", "How a map is written for other programs.");
  group.add("max-words", &options.maxWords, "Largest number of labels for each place.");
  group.add("frame", &options.frame,
            "nav2: the coordinate frame of the poses, as the robot's TF tree names it.");
  group.add("bidirectional", &options.bidirectional, "nav2: an edge each way for every transition.")
      .why("Off where doors or lanes are one-way.");
  return group;
}

Choices exportFormats() {
  Choices choices;
  for (const Format& format : formats) choices.push_back({format.name, format.explanation});
  return choices;
}

std::string exportMap(const TopologicalMap& map, const std::string& format, const ExportOptions& options) {
  requireChoice("export format", format, exportFormats());
  return std::ranges::find(formats, format, &Format::name)->write(map, options);
}

void exportMap(const TopologicalMap& map, const std::string& format, const std::filesystem::path& path,
               const ExportOptions& options) {
  writeWhole(path, exportMap(map, format, options));
}

}  // namespace estancia
