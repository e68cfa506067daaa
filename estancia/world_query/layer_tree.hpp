// Layer tree: the one place that each object belongs to, and the one area of each place. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "estancia/core/pose.hpp"
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

  std::vector<int> objectsOf(std::size_t node) const;
  /// The objects of an area that has no places.
  std::vector<int> objectsBesidePlaces(int area) const;
};

/// The directions of a floor's two axes and of up in the map, as columns.
cv::Matx33d axesOf(const Floor& floor);

}  // namespace estancia
