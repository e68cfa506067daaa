#include "estancia/report/node_cards.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "estancia/report/map_figure.hpp"
#include "estancia/report/word_cloud.hpp"

namespace estancia::report {
namespace {

using Pictures = std::map<std::size_t, std::vector<unsigned char>>;  // by frame

/// At most `count` of the node's frames that have pictures, evenly spread over its life.
std::vector<std::size_t> choosePictures(const NodeSummary& node, const std::vector<std::size_t>& pictured,
                                        std::size_t count) {
  std::vector<std::size_t> candidates, chosen;
  std::set_intersection(node.frames.begin(), node.frames.end(), pictured.begin(), pictured.end(),
                        std::back_inserter(candidates));
  count = std::min(count, candidates.size());
  for (std::size_t i = 0; i < count; ++i)
    chosen.push_back(candidates[(2 * i + 1) * candidates.size() / (2 * count)]);
  return chosen;
}

/// Loads pictures in rounds, one a node and round, until the budget is spent: every node before any has two.
Pictures loadPictures(const std::vector<const NodeSummary*>& nodes, const MapPage& page,
                      std::size_t& withheld) {
  Pictures pictures;
  if (!page.picture) return pictures;
  std::vector<std::vector<std::size_t>> chosen;
  chosen.reserve(nodes.size());
  for (const NodeSummary* node : nodes)
    chosen.push_back(choosePictures(*node, page.pictureFrames, page.picturesPerNode));
  std::size_t left = page.pictureBytes;
  for (std::size_t round = 0; round < page.picturesPerNode; ++round)
    for (const auto& frames : chosen) {
      if (round >= frames.size()) continue;
      // the middle first, should there be room for one only
      const std::size_t frame = frames[(round + frames.size() / 2) % frames.size()];
      std::vector<unsigned char> bytes = left > 0 ? page.picture(frame) : std::vector<unsigned char>{};
      if (left > 0 && bytes.empty()) continue;
      if (left == 0 || bytes.size() > left) {
        left = 0;
        ++withheld;
        continue;
      }
      left -= bytes.size();
      pictures.emplace(frame, std::move(bytes));
    }
  return pictures;
}

void addPictures(Markup& card, const MapSummary& summary, const NodeSummary& node, const Pictures& pictures) {
  std::vector<std::size_t> frames;
  for (const auto& [frame, bytes] : pictures)
    if (summary.map->frames[frame].node == node.node->id) frames.push_back(frame);
  if (frames.empty()) return;
  card.open("div", {{"class", fmt::format("pictures p{}", std::min<std::size_t>(frames.size(), 4))}});
  for (const std::size_t frame : frames) {
    const std::string name = fmt::format("frame {}: {}", frame, shorten(summary.map->frames[frame].name, 80));
    card.leaf("img", {{"src", imageUri(pictures.at(frame), "the picture of " + name)},
                      {"alt", fmt::format("What node {} looks like, {}", node.node->id, name)},
                      {"title", name},
                      {"decoding", "async"}});
  }
  card.close();
}

void addLabels(Markup& card, const MapSummary& summary, const NodeSummary& node) {
  card.open("ol", {{"class", "labels"}});
  const std::vector<std::size_t> best = bestLabels(*node.node, 10);
  const float largest = best.empty() ? 1 : std::max(node.node->mean[best.front()], 1e-6F);
  for (const std::size_t label : best) {
    const float p = node.node->mean[label];
    const std::string& full = summary.map->vocabulary[label];
    card.open("li").element("span", {{"class", "label"}, {"title", shorten(full, 200)}},
                            shorten(firstSynonym(full), 40));
    card.open("span", {{"class", "bar"}})
        .element("i", {{"style", fmt::format("width:{}%", number(p > 0 ? 100 * p / largest : 0, 1))}}, "")
        .close();
    card.element("span", {{"class", "p"}}, significant(p)).close();
  }
  card.close();
}

/// When the node was visited, as a strip over the whole run.
Markup visitStrip(const MapSummary& summary, const NodeSummary& node) {
  constexpr double width = 300;
  const auto frames = static_cast<double>(std::max<std::size_t>(summary.map->frames.size(), 1));
  Path path;
  double drawn = -1;
  for (const Visit& visit : node.visits) {
    const double from = std::max(width * static_cast<double>(visit.first) / frames, drawn);
    const double to = std::max(width * static_cast<double>(visit.last + 1) / frames, from + 1);
    if (to <= drawn + 0.5) continue;  // less than can be seen
    path.move(from, 4).line(to, 4);
    drawn = to;
  }
  Markup strip;
  strip.open("svg", {{"class", "visits"},
                     {"viewBox", fmt::format("0 0 {} 8", width)},
                     {"preserveAspectRatio", "none"},
                     {"role", "img"},
                     {"aria-label", counted(node.visits.size(), "visit") + " over the run"}});
  if (!path.empty()) strip.leaf("path", {{"d", path.str()}});
  return strip.close();
}

void addNeighbours(Markup& card, const MapSummary& summary, std::size_t position) {
  constexpr std::size_t shown = 12;
  std::size_t count = 0;
  card.open("p", {{"class", "neighbours"}}).text("Linked to");
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

std::string seen(const NodeSummary& node) {
  if (node.frames.empty()) return "never seen";
  if (node.frames.size() == 1) return fmt::format("seen once, at frame {}", node.frames.front());
  return fmt::format("{}, frames {} to {}", counted(node.visits.size(), "visit"), node.frames.front(),
                     node.frames.back());
}

void addCard(Markup& out, const MapSummary& summary, std::size_t position, const Pictures& pictures) {
  const NodeSummary& node = summary.nodes[position];
  out.open("article", {{"class", "card"}, {"id", fmt::format("node-{}", node.node->id)}, {"tabindex", "-1"}});
  out.open("header").add(nodeBadge(summary, node)).open("div");
  out.element("h3", shorten(node.room.empty() ? node.title : node.room, 48));
  out.element("p", fmt::format("Node {} · {} · {:.1f} %", node.node->id, counted(node.node->frames, "frame"),
                               100 * node.share));
  out.close().close();
  addPictures(out, summary, node, pictures);
  out.add(wordCloud(*summary.map, *node.node));
  addLabels(out, summary, node);
  out.open("footer").add(visitStrip(summary, node)).element("p", seen(node));
  addNeighbours(out, summary, position);
  out.close().close();
}

void addRow(Markup& out, const MapSummary& summary, std::size_t position) {
  const NodeSummary& node = summary.nodes[position];
  out.open("article", {{"class", "row"}, {"id", fmt::format("node-{}", node.node->id)}, {"tabindex", "-1"}});
  out.element(
      "h3", fmt::format("Node {}{}", node.node->id, node.room.empty() ? "" : " · " + shorten(node.room, 32)));
  std::string words = counted(node.node->frames, "frame") + ", " + seen(node) + ": ";
  for (const std::size_t label : bestLabels(*node.node, 5))
    words += fmt::format("{} {:.3f}  ", shorten(firstSynonym(summary.map->vocabulary[label]), 32),
                         node.node->mean[label]);
  out.element("p", words);
  addNeighbours(out, summary, position);
  out.close();
}

}  // namespace

NodeCards nodeCards(const MapSummary& summary, const MapPage& page) {
  std::vector<std::size_t> order(summary.nodes.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&summary](std::size_t a, std::size_t b) {
    return summary.nodes[a].node->frames > summary.nodes[b].node->frames;
  });
  NodeCards result;
  result.carded = std::min(page.cards, order.size());
  std::vector<char> large(order.size(), 0);
  std::vector<const NodeSummary*> withCards;
  for (std::size_t i = 0; i < result.carded; ++i) {
    large[order[i]] = 1;
    withCards.push_back(&summary.nodes[order[i]]);
  }
  const Pictures pictures = loadPictures(withCards, page, result.withheld);
  for (std::size_t i = 0; i < order.size(); ++i)
    large[i] != 0 ? addCard(result.cards, summary, i, pictures) : addRow(result.rows, summary, i);
  return result;
}

}  // namespace estancia::report
