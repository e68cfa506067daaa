// Layer tree: the one place of each object and the one area of each place; its JSON for Spark-DSG. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <set>
#include <utility>
#include <vector>

#include "estancia/map_file/places.hpp"
#include "estancia/world_file/world_map.hpp"

namespace estancia {

/// Areas → places → objects as a tree, for formats where everything has one parent.
struct LayerTree {
  explicit LayerTree(const WorldMap& world);

  std::vector<Place> places;
  /// In the order of map.nodes; -1 for none.
  std::vector<int> areaOfNode;
  /// For each object an index into map.nodes: of the places in its area the nearest; where it is in no area,
  /// the place of the frame that shows it best; map.nodes.size() where its area has no places.
  std::vector<std::size_t> nodeOfObject;
  std::vector<int> areaOfObject;
  /// Areas that a transition leads between, the smaller number first.
  std::set<std::pair<int, int>> neighbors;

  std::vector<int> objectsOf(std::size_t node) const;
  /// The objects of an area that has no places.
  std::vector<int> objectsBesidePlaces(int area) const;
};

/// The JSON of Spark-DSG's encoding 1.0.3, which 1.0.3 to 1.1 read (`spark_dsg.DynamicSceneGraph.load`):
/// layers objects (2, ids O…), places (3, p…), rooms (4, R…) and one building (5, B0); edges between places
/// that are linked (weight: meters), areas whose places are, objects that stand on each other, and each thing
/// and the one that holds it (LayerTree). semantic_label is the best word's number in the vocabulary, and
/// that is in metadata. Throws Error (insufficientData) where a place has no position.
nlohmann::ordered_json sparkDsgJson(const WorldMap& world);

}  // namespace estancia
