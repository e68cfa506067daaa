// SPDX-License-Identifier: Apache-2.0
#include "estancia/map_file/places.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace estancia {

double distanceBetween(const Position& a, const Position& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

std::vector<Place> placesOf(const TopologicalMap& map) {
  std::vector<Place> places(map.nodes.size());
  std::vector<std::size_t> posed(map.nodes.size(), 0);
  std::vector<std::size_t> placeOf;
  for (const MappedFrame& frame : map.frames) {
    const std::size_t i = indexOf(map, frame.node);
    placeOf.push_back(i);
    if (i == places.size()) continue;
    if (!frame.room.empty()) ++places[i].rooms[frame.room];
    if (!frame.pose) continue;
    if (!places[i].position) places[i].position = Position{};
    Position& sum = *places[i].position;
    sum[0] += frame.pose->x;
    sum[1] += frame.pose->y;
    sum[2] += frame.pose->z;
    ++posed[i];
  }
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (places[i].position)
      for (double& value : *places[i].position) value /= static_cast<double>(posed[i]);
    const auto& rooms = places[i].rooms;
    const auto largest = std::max_element(rooms.begin(), rooms.end(),
                                          [](const auto& a, const auto& b) { return a.second < b.second; });
    if (largest != rooms.end()) places[i].room = largest->first;
  }
  if (map.predictions) {
    auto pooled = poolRooms(*map.predictions, placeOf, places.size());
    const std::vector<bool> sure = areSureRooms(*map.predictions, placeOf, pooled, GroupedBy::labels);
    for (std::size_t i = 0; i < places.size(); ++i) {
      places[i].isNamed = map.predictions->areByName ? sure[i] : !pooled[i].empty();
      places[i].predicted = std::move(pooled[i]);
    }
  }
  return places;
}

std::string Place::displayRoom() const {
  if (!room.empty() || !isNamed) return room;
  return fmt::format("{} {:.0f} %", predicted.front().room, 100 * predicted.front().probability);
}

std::size_t indexOf(const TopologicalMap& map, int node) {
  const Node* found = map.findNode(node);
  return found == nullptr ? map.nodes.size() : static_cast<std::size_t>(found - map.nodes.data());
}

std::vector<std::pair<std::size_t, std::size_t>> linksOf(const TopologicalMap& map) {
  std::vector<std::pair<std::size_t, std::size_t>> links;
  for (const Transition& transition : map.transitions) {
    const std::size_t a = indexOf(map, transition.from), b = indexOf(map, transition.to);
    if (a != b && a != map.nodes.size() && b != map.nodes.size()) links.push_back(std::minmax(a, b));
  }
  std::sort(links.begin(), links.end());
  links.erase(std::unique(links.begin(), links.end()), links.end());
  return links;
}

}  // namespace estancia
