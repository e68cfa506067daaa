// Places: the nodes of a map with position and room. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "estancia/map_file/map.hpp"

namespace estancia {

using Position = std::array<double, 3>;  ///< in the map [m]

double distanceBetween(const Position& a, const Position& b);

struct Place {
  /// Mean of its posed frames (thesis 4.4).
  std::optional<Position> position;
  /// How many of its frames are in which room; unknown rooms left out.
  std::map<std::string, std::size_t> rooms;
  /// The most frequent of them, "" when none is known.
  std::string room;
  /// A room classifier's prediction, best first; empty when none was run. Not the truth.
  std::vector<RoomProbability> predicted;
  /// Whether the best of them is its name: by a classifier always, by rooms' names alone where it is sure.
  bool isNamed = false;

  /// The best prediction where that is its name, else nullptr.
  const RoomProbability* predictedRoom() const { return isNamed ? &predicted.front() : nullptr; }
  /// The name of the room for people: the true one, else the predicted one, else "".
  std::string displayRoom() const;
};

/// One place a node, in the order of map.nodes; one pass over the frames.
std::vector<Place> placesOf(const TopologicalMap& map);

/// The position of a node id in map.nodes; map.nodes.size() when there is none.
std::size_t indexOf(const TopologicalMap& map, int node);

/// Pairs of nodes between which the robot drove, each once, in order: indices in map.nodes, first < second.
std::vector<std::pair<std::size_t, std::size_t>> linksOf(const TopologicalMap& map);

}  // namespace estancia
