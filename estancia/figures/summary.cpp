// SPDX-License-Identifier: Apache-2.0
#include "estancia/figures/summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <unordered_map>

#include "estancia/figures/svg.hpp"
#include "estancia/map_file/places.hpp"
#include "estancia/words/label_concepts.hpp"

namespace estancia::report {
namespace {

using Positions = std::unordered_map<int, std::size_t>;

void gatherFrames(const TopologicalMap& map, const Positions& positions, MapSummary& summary) {
  std::vector<std::map<std::string, std::size_t>> votes(summary.nodes.size());
  std::set<std::string> rooms;
  for (std::size_t i = 0; i < map.frames.size(); ++i) {
    if (!map.frames[i].room.empty()) rooms.insert(map.frames[i].room);
    const auto found = positions.find(map.frames[i].node);
    if (found == positions.end()) continue;
    NodeSummary& node = summary.nodes[found->second];
    node.frames.push_back(i);
    addFrame(node.visits, i);
    if (!map.frames[i].room.empty()) ++votes[found->second][map.frames[i].room];
  }
  summary.roomsDriven = rooms.size();
  for (std::size_t n = 0; n < votes.size(); ++n) {
    const auto best = std::ranges::max_element(votes[n], {}, [](const auto& room) { return room.second; });
    if (best != votes[n].end()) summary.nodes[n].room = best->first;
  }
}

void gatherLinks(const TopologicalMap& map, const Positions& positions, MapSummary& summary) {
  std::map<std::pair<std::size_t, std::size_t>, Link> links;
  for (const Transition& transition : map.transitions) {
    const auto from = positions.find(transition.from), to = positions.find(transition.to);
    if (from == positions.end() || to == positions.end() || from == to) continue;
    const auto [a, b] = std::minmax(from->second, to->second);
    Link& link = links.try_emplace({a, b}, Link{a, b, 0, 0}).first->second;
    (from->second == a ? link.there : link.back) += transition.count;
  }
  for (const auto& [ends, link] : links) summary.links.push_back(link);
}

/// Over all images.
std::vector<float> meanOfRun(const TopologicalMap& map) {
  std::vector<double> sums(map.vocabulary.size(), 0);
  double frames = 0;
  for (const Node& node : map.nodes) {
    frames += static_cast<double>(node.frames);
    for (std::size_t label = 0; label < std::min(sums.size(), node.mean.size()); ++label)
      sums[label] += static_cast<double>(node.frames) * static_cast<double>(node.mean[label]);
  }
  std::vector<float> mean(sums.size(), 0);
  if (frames > 0)
    std::ranges::transform(sums, mean.begin(),
                           [frames](double sum) { return static_cast<float>(sum / frames); });
  return mean;
}

}  // namespace

ClassStyle MapSummary::styleOf(const NodeSummary& node) const {
  const auto found = roomStyles.find(node.room);
  return found == roomStyles.end() ? plainStyle() : found->second;
}

MapSummary summarize(const TopologicalMap& map, const LabelConcepts* concepts) {
  static const LabelConcepts none;
  MapSummary summary;
  summary.map = &map;
  summary.concepts = concepts == nullptr ? &none : concepts;
  const std::vector<float> run = meanOfRun(map);
  Positions positions;
  const std::vector<Place> places = placesOf(map);
  for (const Node& node : map.nodes) {
    positions[node.id] = summary.nodes.size();
    NodeSummary& entry = summary.nodes.emplace_back();
    entry.node = &node;
    const Place& place = places[summary.nodes.size() - 1];
    if (const RoomProbability* predicted = place.predictedRoom()) {
      entry.predicted = describeRooms(place.predicted);
      entry.predictedRoom = predicted->room;
    }
    entry.title = familiarTitle(map.vocabulary, *summary.concepts, node.mean, run);
    if (!map.frames.empty())
      entry.share = static_cast<double>(node.frames) / static_cast<double>(map.frames.size());
  }
  gatherFrames(map, positions, summary);
  gatherLinks(map, positions, summary);

  std::vector<const NodeSummary*> order;
  for (const NodeSummary& node : summary.nodes)
    if (!node.room.empty()) order.push_back(&node);
  std::ranges::stable_sort(order, {}, [](const NodeSummary* node) { return node->frames.front(); });
  for (const NodeSummary* node : order)
    if (summary.roomStyles.try_emplace(node->room, classStyle(summary.rooms.size())).second)
      summary.rooms.push_back(node->room);
  return summary;
}

void addFrame(std::vector<VisitSpan>& visits, std::size_t frame) {
  if (visits.empty() || visits.back().last + 1 < frame)
    visits.push_back({frame, frame});
  else
    visits.back().last = frame;
}

Markup visitStrip(const std::vector<VisitSpan>& visits, std::size_t frames) {
  constexpr double width = 300;
  const auto whole = static_cast<double>(std::max<std::size_t>(frames, 1));
  Path path;
  double drawn = -1;
  for (const VisitSpan& visit : visits) {
    const double from = std::max(width * static_cast<double>(visit.first) / whole, drawn);
    const double to = std::max(width * static_cast<double>(visit.last + 1) / whole, from + 1);
    if (to <= drawn + 0.5) continue;  // less than can be seen
    path.move(from, 4).line(to, 4);
    drawn = to;
  }
  Markup strip;
  strip.open("svg", {{"class", "visits"},
                     {"viewBox", fmt::format("0 0 {} 8", width)},
                     {"preserveAspectRatio", "none"},
                     {"role", "img"},
                     {"aria-label", counted(visits.size(), "visit") + " over the run"}});
  if (!path.empty()) strip.leaf("path", {{"d", path.str()}});
  return strip.close();
}

std::string describeVisits(const std::vector<VisitSpan>& visits) {
  if (visits.empty()) return "never seen";
  if (visits.front().first == visits.back().last)
    return fmt::format("seen once, at frame {}", visits.front().first);
  return fmt::format("{}, frames {} to {}", counted(visits.size(), "visit"), visits.front().first,
                     visits.back().last);
}

}  // namespace estancia::report
