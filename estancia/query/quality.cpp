// SPDX-License-Identifier: Apache-2.0
#include "estancia/query/quality.hpp"

#include <algorithm>
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

/// The diagonal of the box around all posed frames [m].
double extentOf(const TopologicalMap& map) {
  std::optional<Position> low, high;
  for (const MappedFrame& frame : map.frames) {
    if (!frame.pose) continue;
    const Position at{frame.pose->x, frame.pose->y, frame.pose->z};
    if (!low) low = high = at;
    for (std::size_t i = 0; i < 3; ++i) {
      (*low)[i] = std::min((*low)[i], at[i]);
      (*high)[i] = std::max((*high)[i], at[i]);
    }
  }
  return low ? distanceBetween(*low, *high) : 0;
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

double meanLinkLength(const Links& links, const std::vector<Place>& places) {
  double sum = 0;
  std::size_t count = 0;
  for (const auto& [a, b] : links) {
    if (!places[a].position || !places[b].position) continue;
    sum += distanceBetween(*places[a].position, *places[b].position);
    ++count;
  }
  return meanOf(sum, count).value_or(0);
}

double meanNodeDistance(const std::vector<Place>& places) {
  std::vector<Position> posed;
  for (const Place& place : places)
    if (place.position) posed.push_back(*place.position);
  double sum = 0;
  for (std::size_t a = 0; a < posed.size(); ++a)
    for (std::size_t b = 0; b < a; ++b) sum += distanceBetween(posed[a], posed[b]);
  return meanOf(sum, posed.size() * (posed.size() - 1) / 2).value_or(0);
}

OriginalScore originalScore(const TopologicalMap& map, const std::vector<Place>& places, const Links& links,
                            const std::optional<double>& spread) {
  OriginalScore score;
  score.roomPurity = roomPurity(places);
  score.sparseness = sparseness(places.size(), links.size());
  if (spread) {
    const double extent = extentOf(map);
    const auto relative = [extent](double distance) { return extent > 0 ? distance / extent : 0; };
    score.linkCloseness = 1 - relative(meanLinkLength(links, places));
    score.compactness = std::clamp(1 - 2 * relative(*spread), 0.0, 1.0);
    score.spread = relative(meanNodeDistance(places));
  }
  if (score.roomPurity && spread)
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
  std::size_t judged = 0, right = 0, rightByNode = 0;
  for (std::size_t i = 0; i < map.frames.size(); ++i) {
    const MappedFrame& frame = map.frames[i];
    const std::size_t place = indexOf(map, frame.node);
    const std::vector<RoomProbability> own = rankedRooms(*map.predictions, i);
    if (frame.room.empty() || place == places.size() || own.empty()) continue;
    ++judged;
    if (own.front().room == frame.room) ++right;
    if (places[place].predicted.front().room == frame.room) ++rightByNode;
  }
  quality.predictedRoom = meanOf(static_cast<double>(right), judged);
  quality.predictedNodeRoom = meanOf(static_cast<double>(rightByNode), judged);
}

}  // namespace

MapQuality evaluate(const TopologicalMap& map, std::span<const std::string> roomsSeen) {
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
  quality.original = originalScore(map, places, links, quality.spatialSpread);
  compareWithPath(map, places, links, quality);
  judgePredictions(map, places, quality);
  return quality;
}

}  // namespace estancia
