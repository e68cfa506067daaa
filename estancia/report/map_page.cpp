// SPDX-License-Identifier: Apache-2.0
#include "estancia/report/map_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "estancia/core/fail.hpp"
#include "estancia/core/output_file.hpp"
#include "estancia/figures/decision_chart.hpp"
#include "estancia/figures/word_cloud.hpp"
#include "estancia/report/map_figure.hpp"
#include "estancia/report/page_assets.hpp"
#include "estancia/report/page_parts.hpp"
#include "estancia/report/page_words.hpp"
#include "estancia/report/world_section.hpp"
#include "estancia/words/label_concepts.hpp"

namespace estancia {
namespace {

using namespace report;

void addNeighbors(Markup& card, const MapSummary& summary, std::size_t position) {
  constexpr std::size_t shown = 12;
  std::size_t count = 0;
  card.open("p", {{"class", "neighbors"}}).text("Linked to");
  for (const Link& link : summary.links) {
    if (link.a != position && link.b != position) continue;
    if (++count > shown) continue;
    const NodeSummary& other = summary.nodes[link.a == position ? link.b : link.a];
    const std::string id = std::to_string(other.node->id);
    const std::uint64_t out = link.a == position ? link.there : link.back, in = link.there + link.back - out;
    card.text(" ").element(
        "a",
        {{"href", "#node-" + id},
         {"title", fmt::format("{}: driven {}× there, {}× back",
                               shorten(other.room.empty() ? other.title : other.room, 40), out, in)}},
        id);
  }
  if (count > shown) card.text(fmt::format(" and {} more", count - shown));
  if (count == 0) card.text(" no other node");
  card.close();
}

/// Room predicted for the place, and its zone.
void addClasses(Markup& card, const MapSummary& summary, std::size_t position, const NodeZones* zones) {
  const NodeSummary& node = summary.nodes[position];
  if (!node.predicted.empty()) card.element("p", "Taken for " + shorten(node.predicted, 90));
  if (zones != nullptr) card.add(zoneLine(*zones, position));
}

void addCard(Markup& out, const MapSummary& summary, std::size_t position, const NodeZones* zones,
             Painting painting, const LoadedImages& images) {
  const NodeSummary& node = summary.nodes[position];
  const bool byZone = painting == Painting::zones && zones != nullptr;
  out.open("article", {{"class", "card"},
                       {"id", fmt::format("node-{}", node.node->id)},
                       {"data-node", position},
                       {"tabindex", "-1"}});
  out.open("header")
      .add(badge(byZone ? zones->styleOf(position) : summary.styleOf(node), std::to_string(node.node->id)))
      .open("div");
  out.element("h3", shorten(!node.room.empty()            ? node.room
                            : !node.predictedRoom.empty() ? node.predictedRoom
                                                          : node.title,
                            48));
  out.element("p", fmt::format("Node {} · {} · {:.1f} %", node.node->id, counted(node.node->frames, "frame"),
                               100 * node.share));
  addClasses(out, summary, position, zones);
  out.close().close();
  const auto nameOf = [&summary](std::size_t frame) { return summary.map->frames[frame].name; };
  out.add(imageGrid(images, node.frames, fmt::format("What node {} looks like", node.node->id), nameOf));
  out.add(wordCloud(summary.map->vocabulary, *summary.concepts, node.node->mean));
  out.add(labelBars(summary.map->vocabulary, *summary.concepts, node.node->mean, {}, 10));
  out.open("footer")
      .add(visitStrip(node.visits, summary.map->frames.size()))
      .element("p", describeVisits(node.visits));
  addNeighbors(out, summary, position);
  out.close().close();
}

void addRow(Markup& out, const MapSummary& summary, std::size_t position, const NodeZones* zones) {
  const NodeSummary& node = summary.nodes[position];
  out.open("article", {{"class", "row"}, {"id", fmt::format("node-{}", node.node->id)}, {"tabindex", "-1"}});
  out.element(
      "h3", fmt::format("Node {}{}", node.node->id, node.room.empty() ? "" : " · " + shorten(node.room, 32)));
  std::string words = counted(node.node->frames, "frame") + ", " + describeVisits(node.visits) + ": ";
  for (const FamiliarWord& word :
       familiarWords(summary.map->vocabulary, *summary.concepts, node.node->mean, 5))
    words += fmt::format("{} {:.3f}  ", shorten(word.name, 32), word.probability);
  out.element("p", words);
  addClasses(out, summary, position, zones);
  addNeighbors(out, summary, position);
  out.close();
}

/// `zones` may be nullptr. Badges have the colors of zones where the painting is of zones, else of rooms;
/// every card carries the node's position as data-node.
Cards nodeCards(const MapSummary& summary, const MapPage& page, const NodeZones* zones, Painting painting) {
  std::vector<std::uint64_t> frames;
  for (const NodeSummary& node : summary.nodes) frames.push_back(node.node->frames);
  const std::vector<std::size_t> order = largestFirst(frames);
  Cards result;
  result.carded = std::min(page.cards, order.size());
  result.listed = order.size() - result.carded;
  std::vector<char> large(order.size(), 0);
  std::vector<const std::vector<std::size_t>*> withCards;
  for (std::size_t i = 0; i < result.carded; ++i) {
    large[order[i]] = 1;
    withCards.push_back(&summary.nodes[order[i]].frames);
  }
  const LoadedImages images = loadImages(withCards, page.images);
  result.withheld = images.withheld;
  for (std::size_t i = 0; i < order.size(); ++i)
    large[i] != 0 ? addCard(result.cards, summary, i, zones, painting, images)
                  : addRow(result.rows, summary, i, zones);
  return result;
}

Markup headerOf(const MapPage& page, const MapSummary& summary) {
  const TopologicalMap& map = page.map;
  std::vector<std::pair<std::size_t, std::string>> counts{
      {map.frames.size(), "frame"}, {map.nodes.size(), "node"}, {map.transitions.size(), "transition"}};
  if (map.drives.size() > 1) counts.emplace(counts.begin(), map.drives.size(), "drive");
  if (!map.merges.empty()) counts.emplace_back(map.merges.size(), "merge");
  if (summary.roomsDriven > 0) counts.emplace_back(summary.roomsDriven, "room");
  if (page.world != nullptr && !page.world->world.areas.empty())
    counts.emplace_back(page.world->world.areas.size(), "area");
  if (page.world != nullptr && !page.world->world.objects.empty())
    counts.emplace_back(page.world->world.objects.size(), "object");
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
    const Color color = heat.colorOf(n);
    body.add(bar(100 * heat.values[n] / heat.largest, &color));
    body.element("span", {{"class", "p"}}, significant(heat.values[n])).close().close();
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

/// Initial state of the page.
Painting paintingOf(const MapPage& page, const MapSummary& summary) {
  return page.label              ? Painting::heat
         : page.zones != nullptr ? Painting::zones
         : summary.rooms.empty() ? Painting::heat
                                 : Painting::rooms;
}

/// `example`: a word that finds something; "" where there is none. `choosers`: buttons beside it.
Markup searchForm(const std::string& example, const Markup& choosers) {
  Markup form;
  form.open("form", {{"id", "search"}, {"role", "search"}, {"hidden", ""}});
  form.element("label", {{"for", "word"}}, "Find a word on the map");
  form.open("div", {{"class", "search-row"}});
  Attributes input{{"id", "word"},
                   {"type", "search"},
                   {"list", "words"},
                   {"autocomplete", "off"},
                   {"spellcheck", "false"}};
  if (!example.empty()) input.push_back({"placeholder", "e.g. " + example});
  form.leaf("input", input);
  form.element("datalist", {{"id", "words"}}, "");
  form.element("button", {{"type", "submit"}}, "Show").add(choosers);
  return form.close().open("p", {{"id", "hint"}, {"aria-live", "polite"}}).close().close();
}

/// `hasForm`: whether the search form is here; else it is on the floor plan.
void addExplorer(Markup& body, const MapPage& page, const MapSummary& summary, const NodeZones* zones,
                 bool hasForm) {
  const Painting painting = paintingOf(page, summary);
  const HeatMap heat = heatMapOf(page.map, page.label.value_or(distinctiveLabel(page.map)));
  const FloorPlan* plan = page.floorPlan ? &*page.floorPlan : nullptr;
  const MapLayout layout = layoutMap(summary, plan != nullptr);
  if (plan != nullptr) requireFitting(*plan, layout.frames);

  body.open("section", {{"class", "explore"}, {"id", "map"}, {"aria-label", "Map"}});
  Markup choosers;
  const auto chooser = [&choosers, painting](const char* id, Painting what, const char* text) {
    choosers.element("button",
                     {{"type", "button"}, {"id", id}, {"aria-pressed", painting == what ? "true" : "false"}},
                     text);
  };
  if (!summary.rooms.empty()) chooser("by-rooms", Painting::rooms, "Color by room");
  if (zones != nullptr) chooser("by-zones", Painting::zones, "Color by zone");
  if (hasForm)
    body.add(searchForm(shorten(firstSynonym(page.map.vocabulary[heat.label]), 30), choosers));
  else
    body.open("div", {{"class", "choosers"}})
        .element("h2", "Map of places")
        .open("div", {{"class", "search-row"}})
        .add(choosers)
        .close()
        .close();

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

/// Data of the script: labels, nodes, and for each node a flat list of (step to the next label, p in
/// 1/10,000).
nlohmann::json searchIndex(const MapPage& page, const MapSummary& summary, const NodeZones* zones,
                           double& threshold) {
  const auto entries = [&page](double least) {
    std::size_t count = 0;
    for (const Node& node : page.map.nodes)
      count +=
          static_cast<std::size_t>(std::ranges::count_if(node.mean, [&](float p) { return p >= least; }));
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
  // labels that no node holds stay in the list, so that a search for them can report this
  for (const std::string& label : page.map.vocabulary.labels()) labels.push_back(shorten(label, 200));
  for (const Color& color : viridisStops()) colors.push_back({color.red, color.green, color.blue});
  for (std::size_t shape = 0; shape < 5; ++shape) shapes.push_back(shapePath(shape, unitRadius));
  return {{"labels", labels}, {"nodes", nodes},   {"index", index},
          {"colors", colors}, {"shapes", shapes}, {"least", threshold}};
}

}  // namespace

std::string renderMapPage(const MapPage& page) {
  const MapSummary summary = summarize(page.map, page.concepts);
  std::optional<NodeZones> laidOver;
  if (page.zones != nullptr) laidOver = zonesOf(summary, *page.zones);
  const NodeZones* zones = laidOver ? &*laidOver : nullptr;
  double threshold = 0;
  nlohmann::json data = searchIndex(page, summary, zones, threshold);
  if (nlohmann::json words = pageWords(page); !words.is_null()) data["words"] = std::move(words);
  std::optional<WorldView> world;
  if (page.world != nullptr && hasLayers(page.world->world)) world.emplace(viewOf(*page.world));

  Markup body;
  body.element("a", {{"class", "skip"}, {"href", "#places"}}, "Skip to the places");
  body.open("main");
  body.add(headerOf(page, summary));
  if (page.map.nodes.empty()) {
    body.element("p", {{"class", "note"}}, "This map has no nodes yet.");
  } else {
    if (world) {
      body.add(worldSection(*world, searchForm(exampleWord(world->world), {}))).add(worldList(*world));
      data["world"] = worldData(*world);
    }
    addExplorer(body, page, summary, zones, !world);
    const Cards cards = nodeCards(summary, page, zones, paintingOf(page, summary));
    std::string limits, search;
    if (cards.listed > 0)
      limits = fmt::format("Images and word clouds are shown for the {} largest of {} nodes. ", cards.carded,
                           summary.nodes.size());
    if (threshold > 0.0005)
      search = fmt::format("The search leaves out probabilities below {}.", significant(threshold));
    body.add(placesSection("Places", limits, cards, search, "The " + counted(cards.listed, "smaller node")));
  }
  if (!page.map.decisions.empty()) {
    body.open("section", {{"id", "decisions"}}).element("h2", "Decisions over time");
    body.add(decisionChart(page.map)).close();
  }
  body.add(measuresSection(page.measures));
  body.close();
  return htmlDocument(page.title, mapPageCss + (world ? worldPageCss : ""), body,
                      data.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace),
                      wordSearchScript + (world ? worldPageScript : "") + mapPageScript);
}

void writeMapPage(const std::filesystem::path& path, const MapPage& page) {
  writeWhole(path, renderMapPage(page));
}

}  // namespace estancia
