#include "estancia/report/map_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "estancia/core/error.hpp"
#include "estancia/core/output_file.hpp"
#include "estancia/report/decision_chart.hpp"
#include "estancia/report/map_figure.hpp"
#include "estancia/report/node_cards.hpp"
#include "estancia/report/page_assets.hpp"
#include "estancia/report/page_parts.hpp"
#include "estancia/report/symbols.hpp"

namespace estancia {
namespace {

using namespace report;

Markup headerOf(const MapPage& page, const MapSummary& summary) {
  const TopologicalMap& map = page.map;
  std::vector<std::pair<std::size_t, std::string>> counts{
      {map.frames.size(), "frame"}, {map.nodes.size(), "node"}, {map.transitions.size(), "transition"}};
  if (!map.merges.empty()) counts.emplace_back(map.merges.size(), "merge");
  if (summary.roomsDriven > 0) counts.emplace_back(summary.roomsDriven, "room");
  Facts facts{{"Sequence", shorten(page.sequence, 200)},
              {"Model", abbreviate(map.model)},
              {"Distance", shorten(map.distance, 120)}};
  if (!map.decisions.empty())
    facts.emplace_back("Thresholds",
                       fmt::format("τ join {}, τ revisit {}", significant(map.decisions.back().tauJoin),
                                   significant(map.decisions.back().tauRevisit)));
  facts.emplace_back("Vocabulary", counted(map.vocabulary.size(), "label"));
  facts.emplace_back("Date", shorten(page.date, 60));
  return pageHeader(page.title, counts, facts);
}

void addRanking(Markup& body, const MapSummary& summary, const HeatMap& heat) {
  body.open("div", {{"class", "panel"}, {"id", "ranking"}, {"aria-live", "polite"}});
  body.element("h2", "Where is “" + shorten(firstSynonym(summary.map->vocabulary[heat.label]), 40) + "”?");
  body.open("ol", {{"class", "places"}});
  for (const std::size_t n : heat.ranking(10)) {
    const NodeSummary& node = summary.nodes[n];
    const std::string id = std::to_string(node.node->id);
    body.open("li").open("a", {{"href", "#node-" + id}, {"data-node", n}});
    body.element("b", id).element("span", {{"class", "label"}},
                                  shorten(node.room.empty() ? node.title : node.room, 40));
    body.open("span", {{"class", "bar"}});
    body.element(
        "i",
        {{"style", fmt::format("width:{}%;background:{}", number(100 * heat.values[n] / heat.largest, 1),
                               heat.colorOf(n).hex())}},
        "");
    body.close().element("span", {{"class", "p"}}, significant(heat.values[n])).close().close();
  }
  body.close().close();
}

void addGuide(Markup& body, bool metric, bool zones) {
  body.open("div", {{"class", "panel guide"}}).element("h2", "How to read this page");
  body.element(
      "p",
      "A node is a place that the robot told apart by the words its images evoke: it holds the mean "
      "probability of every label over its images. Search a word to see where it is likely; select a "
      "node for its words and images; the chart of decisions shows why the mapper stayed, moved or "
      "founded a new place.");
  body.element("p",
               metric ? "Nodes lie where their images were taken, moved apart where they would overlap. The "
                        "dotted line is the driven path. Symbols grow with the number of images, lines with "
                        "how often they were driven."
                      : "No poses are known, so nodes are placed by the number of transitions between them. "
                        "Symbols grow with the number of images, lines with how often they were driven.");
  if (zones)
    body.element(
        "p",
        "A zone holds images whose words are alike, wherever they were taken; a node has the color and "
        "shape of the zone that most of its images are in.");
  body.close();
}

/// What the page starts as.
Painting paintingOf(const MapPage& page, const MapSummary& summary) {
  return page.label              ? Painting::heat
         : page.zones != nullptr ? Painting::zones
         : summary.rooms.empty() ? Painting::heat
                                 : Painting::rooms;
}

void addExplorer(Markup& body, const MapPage& page, const MapSummary& summary, const NodeZones* zones) {
  const Painting painting = paintingOf(page, summary);
  const HeatMap heat = heatMapOf(page.map, page.label.value_or(mostTellingLabel(page.map)));
  const FloorPlan* plan = page.floorPlan ? &*page.floorPlan : nullptr;
  const MapLayout layout = layoutMap(summary, plan != nullptr);
  if (plan != nullptr && !layout.metric)
    throw Error("a floor plan needs frames with poses, and this map has none; leave the floor plan out");

  body.open("section", {{"class", "explore"}, {"id", "map"}, {"aria-label", "Map"}});
  body.open("form", {{"id", "search"}, {"role", "search"}, {"hidden", ""}});
  body.element("label", {{"for", "word"}}, "Find a word on the map");
  body.open("div", {{"class", "search-row"}});
  body.leaf("input", {{"id", "word"},
                      {"type", "search"},
                      {"list", "words"},
                      {"autocomplete", "off"},
                      {"spellcheck", "false"},
                      {"placeholder", "e.g. " + shorten(firstSynonym(page.map.vocabulary[heat.label]), 30)}});
  body.element("datalist", {{"id", "words"}}, "");
  body.element("button", {{"type", "submit"}}, "Show");
  const auto chooser = [&body, painting](const char* id, Painting what, const char* text) {
    body.element("button",
                 {{"type", "button"}, {"id", id}, {"aria-pressed", painting == what ? "true" : "false"}},
                 text);
  };
  if (!summary.rooms.empty()) chooser("by-rooms", Painting::rooms, "Color by room");
  if (zones != nullptr) chooser("by-zones", Painting::zones, "Color by zone");
  body.close().open("p", {{"id", "hint"}, {"aria-live", "polite"}}).close().close();

  body.open("div", {{"class", "figure"}});
  const MapColors colors{heat, zones, painting};
  body.add(mapFigure(summary, layout, colors, plan, {780, 580, 12.5, true, "wide"}));
  body.add(mapFigure(summary, layout, colors, plan, {358, 440, 11, false, "narrow"}));
  const auto legend = [&body, painting](const char* id, Painting what, const Markup& entries) {
    Attributes attributes{{"id", id}};
    if (painting != what) attributes.push_back({"hidden", ""});
    body.open("div", attributes).add(entries).close();
  };
  legend("legend-rooms", Painting::rooms, roomLegend(summary));
  if (zones != nullptr) legend("legend-zones", Painting::zones, zoneLegend(*zones));
  legend("legend-heat", Painting::heat, heatLegend(heat));
  body.close().open("div", {{"class", "side"}});
  addRanking(body, summary, heat);
  body.element("div", {{"class", "panel"}, {"id", "detail"}, {"hidden", ""}, {"tabindex", "-1"}}, "");
  body.close();
  addGuide(body, layout.metric, zones != nullptr);
  body.close();
}

/// What the script needs: labels, nodes, and for each node its labels as a flat list of
/// (step from the previous label, p in 1/10,000).
std::string searchIndex(const MapPage& page, const MapSummary& summary, const NodeZones* zones,
                        double& threshold) {
  const auto entries = [&page](double least) {
    std::size_t count = 0;
    for (const Node& node : page.map.nodes)
      count += static_cast<std::size_t>(
          std::count_if(node.mean.begin(), node.mean.end(), [least](float p) { return p >= least; }));
    return count;
  };
  threshold = 0.0005;
  while (threshold < 1 && entries(threshold) > page.indexEntries) threshold *= 2;

  nlohmann::json index = nlohmann::json::array(), nodes = index, labels = index, colors = index,
                 shapes = index;
  std::vector<char> used(page.map.vocabulary.size(), 0);
  for (const NodeSummary& node : summary.nodes) {
    nlohmann::json row = nlohmann::json::array();
    std::size_t previous = 0;
    const auto& mean = node.node->mean;
    for (std::size_t label = 0; label < std::min(mean.size(), used.size()); ++label)
      if (mean[label] >= threshold) {
        row.push_back(label - previous);
        row.push_back(std::lround(1e4 * std::min(mean[label], 1.0F)));
        previous = label;
        used[label] = 1;
      }
    index.push_back(std::move(row));
    const ClassStyle room = summary.styleOf(node);
    nodes.push_back({node.node->id, shorten(node.room.empty() ? node.title : node.room, 40), room.fill.hex(),
                     room.shape});
    if (zones != nullptr) {
      const ClassStyle zone = zones->styleOf(nodes.size() - 1);
      nodes.back().insert(nodes.back().end(), {zone.fill.hex(), zone.shape});
    }
  }
  // a label no node holds stays in the list, so that searching for it can say so
  for (const std::string& label : page.map.vocabulary.labels()) labels.push_back(shorten(label, 200));
  for (const Color& color : viridisStops()) colors.push_back({color.red, color.green, color.blue});
  for (std::size_t shape = 0; shape < 5; ++shape) shapes.push_back(shapePath(shape, unitRadius));
  nlohmann::json data{{"labels", labels}, {"nodes", nodes},   {"index", index},
                      {"colors", colors}, {"shapes", shapes}, {"least", threshold}};
  return data.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace

FloorPlan readFloorPlan(const std::filesystem::path& path, const std::array<double, 4>& extent) {
  FloorPlan plan{{}, extent[0], extent[1], extent[2], extent[3]};
  const bool finite = std::all_of(extent.begin(), extent.end(), [](double v) { return std::isfinite(v); });
  if (!finite || !(plan.xMax > plan.xMin) || !(plan.yMax > plan.yMin))
    throw Error(
        "the floor plan's extent must be xMin, yMin, xMax, yMax in meters, with xMin < xMax and yMin < yMax");
  constexpr std::size_t limit = 8'000'000;
  std::ifstream file(path, std::ios::binary);
  if (!file) throw Error(fmt::format("cannot read the floor plan {}; check the path", path.string()));
  plan.image.resize(limit + 1);
  file.read(reinterpret_cast<char*>(plan.image.data()), static_cast<std::streamsize>(plan.image.size()));
  plan.image.resize(static_cast<std::size_t>(file.gcount()));
  if (plan.image.size() > limit)
    throw Error(fmt::format("the floor plan {} is larger than 8 MB; make it smaller", path.string()));
  imageUri(plan.image, path.string());  // checks the format
  return plan;
}

std::string renderMapPage(const MapPage& page) {
  const MapSummary summary = summarize(page.map);
  std::optional<NodeZones> laidOver;
  if (page.zones != nullptr) laidOver = zonesOf(summary, *page.zones);
  const NodeZones* zones = laidOver ? &*laidOver : nullptr;
  double threshold = 0;
  const std::string data = searchIndex(page, summary, zones, threshold);

  Markup body;
  body.element("a", {{"class", "skip"}, {"href", "#places"}}, "Skip to the places");
  body.open("main");
  body.add(headerOf(page, summary));
  if (page.map.nodes.empty()) {
    body.element("p", {{"class", "note"}}, "This map has no nodes yet.");
  } else {
    addExplorer(body, page, summary, zones);
    const NodeCards cards = nodeCards(summary, page, zones, paintingOf(page, summary));
    body.open("section", {{"id", "places"}}).element("h2", "Places");
    std::string limits;
    if (cards.carded < summary.nodes.size())
      limits = fmt::format("Images and word clouds are shown for the {} largest of {} nodes. ", cards.carded,
                           summary.nodes.size());
    if (cards.withheld > 0)
      limits += counted(cards.withheld, "image") + " left out to keep this page small. ";
    if (threshold > 0.0005)
      limits += fmt::format("The search leaves out probabilities below {}.", significant(threshold));
    if (!limits.empty()) body.element("p", {{"class", "note"}}, limits);
    body.open("div", {{"class", "cards"}}).add(cards.cards).close();
    if (!cards.rows.empty()) {
      body.open("details", {{"id", "smaller"}});
      body.element("summary", "The " + counted(summary.nodes.size() - cards.carded, "smaller node"));
      body.add(cards.rows).close();
    }
    body.close();
  }
  if (!page.map.decisions.empty()) {
    body.open("section", {{"id", "decisions"}}).element("h2", "Decisions over time");
    body.add(decisionChart(page.map)).close();
  }
  body.add(measuresSection(page.measures));
  body.close();
  return htmlDocument(page.title, mapPageCss, body, data, mapPageScript);
}

void writeMapPage(const std::filesystem::path& path, const MapPage& page) {
  writeWhole(path, renderMapPage(page));
}

}  // namespace estancia
