#include "estancia/report/node_cards.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "estancia/report/label_bars.hpp"
#include "estancia/report/symbols.hpp"
#include "estancia/report/word_cloud.hpp"

namespace estancia::report {
namespace {

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

/// What a classifier takes the place for.
void addPrediction(Markup& card, const NodeSummary& node) {
  if (!node.predicted.empty()) card.element("p", "Taken for " + shorten(node.predicted, 90));
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
  addPrediction(out, node);
  if (zones != nullptr) out.add(zoneLine(*zones, position));
  out.close().close();
  const auto nameOf = [&summary](std::size_t frame) { return summary.map->frames[frame].name; };
  out.add(imageGrid(images, node.frames, fmt::format("What node {} looks like", node.node->id), nameOf));
  out.add(wordCloud(*summary.map, *node.node));
  out.add(labelBars(summary.map->vocabulary, node.node->mean, {}, 10));
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
  for (const std::size_t label : bestLabels(*node.node, 5))
    words += fmt::format("{} {:.3f}  ", shorten(firstSynonym(summary.map->vocabulary[label]), 32),
                         node.node->mean[label]);
  out.element("p", words);
  addPrediction(out, node);
  if (zones != nullptr) out.add(zoneLine(*zones, position));
  addNeighbors(out, summary, position);
  out.close();
}

}  // namespace

NodeCards nodeCards(const MapSummary& summary, const MapPage& page, const NodeZones* zones,
                    Painting painting) {
  std::vector<std::size_t> order(summary.nodes.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&summary](std::size_t a, std::size_t b) {
    return summary.nodes[a].node->frames > summary.nodes[b].node->frames;
  });
  NodeCards result;
  result.carded = std::min(page.cards, order.size());
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

}  // namespace estancia::report
