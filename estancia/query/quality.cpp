// SPDX-License-Identifier: Apache-2.0
#include "estancia/query/quality.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "estancia/core/error.hpp"
#include "estancia/map_file/places.hpp"

namespace estancia {
namespace {

using Links = std::vector<std::pair<std::size_t, std::size_t>>;

std::optional<double> meanOf(double sum, std::size_t count) {
  return count == 0 ? std::nullopt : std::optional(sum / static_cast<double>(count));
}

/// Frames in no node are left out.
NamedAgreement agreementWith(std::vector<std::string> rooms, const TopologicalMap& map) {
  std::vector<int> nodes;
  for (std::size_t i = 0; i < map.frames.size(); ++i) {
    nodes.push_back(map.frames[i].node);
    if (i < rooms.size() && map.findNode(nodes[i]) == nullptr) rooms[i].clear();
  }
  return measureNamedAgreement(rooms, nodes);
}

std::vector<std::string> roomsOf(const TopologicalMap& map) {
  std::vector<std::string> rooms;
  for (const MappedFrame& frame : map.frames) rooms.push_back(frame.room);
  return rooms;
}

std::optional<double> roomPurity(const std::vector<Place>& places) {
  double sum = 0;
  std::size_t count = 0;
  for (const Place& place : places) {
    if (place.rooms.empty()) continue;
    double frames = 0, mainRoom = 0;
    for (const auto& [room, inRoom] : place.rooms) {
      frames += static_cast<double>(inRoom);
      mainRoom = std::max(mainRoom, static_cast<double>(inRoom));
    }
    const auto others = static_cast<double>(place.rooms.size() - 1);
    sum += others == 0 ? 1 : 1 - (frames - mainRoom) / others / mainRoom;
    ++count;
  }
  return meanOf(sum, count);
}

double sparseness(std::size_t nodes, std::size_t links) {
  const auto n = static_cast<double>(nodes), e = static_cast<double>(links);
  if (nodes < 3) return links == 0 ? n - 1 : (n - 1) / n;  // the formula has no value at two nodes: as a tree
  return std::clamp((n * (n - 1) - 2 * e) / (n * (n - 2)), 0.0, 1.0);
}

std::optional<double> spatialSpread(const TopologicalMap& map, const std::vector<Place>& places) {
  double sum = 0;
  std::size_t count = 0;
  for (const MappedFrame& frame : map.frames) {
    const std::size_t i = indexOf(map, frame.node);
    if (!frame.pose || i == places.size()) continue;
    sum += distanceBetween({frame.pose->x, frame.pose->y, frame.pose->z}, *places[i].position);
    ++count;
  }
  return meanOf(sum, count);
}

struct Point {
  double x = 0, y = 0;
};

double distanceBetween(const Point& a, const Point& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

/// `points`: at least one.
Point centerOf(const std::vector<Point>& points) {
  Point sum;
  for (const Point& each : points) sum = {sum.x + each.x, sum.y + each.y};
  const auto count = static_cast<double>(points.size());
  return {sum.x / count, sum.y / count};
}

/// Where the images of a node were taken.
struct Footprint {
  Point mean, last, typical;  ///< typical: nearest to the median
};

/// `taken` is not empty.
Footprint footprintOf(const std::vector<Point>& taken) {
  const auto upperMedian = [&](double Point::*coordinate) {
    std::vector<double> values;
    for (const Point& each : taken) values.push_back(each.*coordinate);
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::ranges::nth_element(values, middle);
    return *middle;
  };
  const Point median{upperMedian(&Point::x), upperMedian(&Point::y)};
  const auto fromMedian = [&](const Point& each) { return distanceBetween(each, median); };
  return {centerOf(taken), taken.back(), *std::ranges::min_element(taken, {}, fromMedian)};
}

/// None for a node without a posed image.
std::vector<std::optional<Footprint>> footprintsOf(const TopologicalMap& map) {
  std::vector<std::vector<Point>> taken(map.nodes.size());
  for (const MappedFrame& frame : map.frames)
    if (const std::size_t i = indexOf(map, frame.node); frame.pose && i < taken.size())
      taken[i].push_back({frame.pose->x, frame.pose->y});
  std::vector<std::optional<Footprint>> found(map.nodes.size());
  for (std::size_t i = 0; i < taken.size(); ++i)
    if (!taken[i].empty()) found[i] = footprintOf(taken[i]);
  return found;
}

/// The diagonal of the box around all posed frames, in x and y [m].
double extentOf(const TopologicalMap& map) {
  std::optional<Point> low, high;
  for (const MappedFrame& frame : map.frames) {
    if (!frame.pose) continue;
    if (!low) low = high = Point{frame.pose->x, frame.pose->y};
    *low = {std::min(low->x, frame.pose->x), std::min(low->y, frame.pose->y)};
    *high = {std::max(high->x, frame.pose->x), std::max(high->y, frame.pose->y)};
  }
  return low ? distanceBetween(*low, *high) : 0;
}

double meanLinkLength(const Links& links, const std::vector<std::optional<Footprint>>& nodes) {
  double sum = 0;
  std::size_t count = 0;
  for (const auto& [a, b] : links) {
    if (!nodes[a] || !nodes[b]) continue;
    sum += distanceBetween(nodes[a]->typical, nodes[b]->typical);
    ++count;
  }
  return meanOf(sum, count).value_or(0);
}

OriginalScore originalScore(const TopologicalMap& map, const std::vector<Place>& places, const Links& links,
                            const std::optional<double>& givenExtent) {
  OriginalScore score;
  score.roomPurity = roomPurity(places);
  score.sparseness = sparseness(places.size(), links.size());
  const std::vector<std::optional<Footprint>> nodes = footprintsOf(map);
  std::vector<Point> positions;
  double toLast = 0;
  for (const auto& node : nodes) {
    if (!node) continue;
    positions.push_back(node->typical);
    toLast += distanceBetween(node->mean, node->last);
  }
  if (positions.empty()) return score;
  const Point center = centerOf(positions);
  double squares = 0;
  for (const Point& each : positions) squares += std::pow(distanceBetween(each, center), 2);
  const auto count = static_cast<double>(positions.size());
  const double extent = givenExtent.value_or(extentOf(map));
  const auto relative = [extent](double distance) { return extent > 0 ? distance / extent : 0; };
  score.linkCloseness = 1 - relative(meanLinkLength(links, nodes));
  score.compactness = 1 - 2 * relative(toLast / count);
  score.spread = 2 * relative(std::sqrt(squares / count));
  if (score.roomPurity)
    score.total = 20 * (*score.roomPurity + score.sparseness + *score.linkCloseness + *score.compactness +
                        *score.spread);
  return score;
}

void compareWithPath(const TopologicalMap& map, const std::vector<Place>& places, const Links& links,
                     MapQuality& quality) {
  using Pair = std::pair<std::string, std::string>;
  const auto ordered = [](const std::string& a, const std::string& b) { return Pair(std::minmax(a, b)); };
  std::set<Pair> driven;
  for (std::size_t i = 1; i < map.frames.size(); ++i) {
    if (map.beginsDrive(i)) continue;  // the robot was carried
    const std::string& before = map.frames[i - 1].room;
    const std::string& now = map.frames[i].room;
    if (!before.empty() && !now.empty() && before != now) driven.insert(ordered(before, now));
  }
  std::set<Pair> found;
  std::size_t judged = 0, right = 0;
  for (const auto& [a, b] : links) {
    if (places[a].room.empty() || places[b].room.empty()) continue;
    const Pair pair = ordered(places[a].room, places[b].room);
    const bool linked = driven.contains(pair);
    if (linked) found.insert(pair);
    if (linked || pair.first == pair.second) ++right;
    ++judged;
  }
  quality.trueLinks = driven.size();
  quality.edgePrecision = meanOf(static_cast<double>(right), judged);
  quality.edgeRecall = meanOf(static_cast<double>(found.size()), driven.size());
}

void judgePredictions(const TopologicalMap& map, const std::vector<Place>& places, MapQuality& quality) {
  if (!map.predictions) return;
  const std::vector<std::string>& known = map.predictions->rooms;
  std::size_t judged = 0, right = 0, rightByNode = 0;
  for (std::size_t i = 0; i < map.frames.size(); ++i) {
    const MappedFrame& frame = map.frames[i];
    const std::size_t place = indexOf(map, frame.node);
    const std::vector<RoomProbability> own = rankedRooms(*map.predictions, i);
    if (frame.room.empty() || place == places.size() || own.empty()) continue;
    // Names that no true room has ("PA" is none) are no answers that could be right.
    if (map.predictions->areByName && std::ranges::find(known, frame.room) == known.end()) continue;
    ++judged;
    if (own.front().room == frame.room) ++right;
    if (places[place].predicted.front().room == frame.room) ++rightByNode;
  }
  quality.predictedRoom = meanOf(static_cast<double>(right), judged);
  quality.predictedNodeRoom = meanOf(static_cast<double>(rightByNode), judged);
}

}  // namespace

MapQuality evaluate(const TopologicalMap& map, std::span<const std::string> roomsSeen,
                    const std::optional<double>& originalExtent) {
  if (map.nodes.empty())
    throw Error(ErrorCode::insufficientData, "the map has no places yet; map some images first");
  const std::vector<Place> places = placesOf(map);
  const Links links = linksOf(map);
  MapQuality quality;
  quality.nodes = map.nodes.size();
  quality.transitions = map.transitions.size();
  quality.links = links.size();
  quality.frames = map.frames.size();
  quality.framesWithRoom = static_cast<std::size_t>(std::count_if(
      map.frames.begin(), map.frames.end(), [](const MappedFrame& frame) { return !frame.room.empty(); }));
  quality.rooms = agreementWith(roomsOf(map), map).agreement;
  if (!roomsSeen.empty()) {
    const NamedAgreement seen = agreementWith({roomsSeen.begin(), roomsSeen.end()}, map);
    quality.framesWithRoomSeen = seen.items;
    quality.roomsSeen = seen.agreement;
  }
  quality.spatialSpread = spatialSpread(map, places);
  quality.original = originalScore(map, places, links, originalExtent);
  compareWithPath(map, places, links, quality);
  judgePredictions(map, places, quality);
  return quality;
}

}  // namespace estancia
