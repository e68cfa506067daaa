// World map: places, areas and objects of one drive as plain data, and how they are read from a map file.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "estancia/areas/area_plan.hpp"
#include "estancia/topology/map.hpp"

namespace estancia {

/// An area as the map knows it.
struct WorldArea : Area {
  /// What people call it; "" where nobody gave it a name.
  std::string givenName = {};

  /// For people: the given name, else the telling words.
  const std::string& displayName() const { return givenName.empty() ? name : givenName; }
};

/// The layers of a map. Invariants: areaOfFrame has one entry a frame (-1 where there are no areas) and no
/// area that does not exist; plan.areas equals areas without what people added.
struct WorldMap {
  TopologicalMap places;
  /// Absent without poses and depth.
  std::optional<AreaPlan> plan = {};
  std::vector<WorldArea> areas = {};
  std::vector<int> areaOfFrame = {};
  /// Corrections by people, in the order they were made.
  std::vector<AreaEdit> edits = {};

  /// The area of most frames of a place; -1 where there are no areas.
  int areaOfNode(int node) const;
  /// nullptr when there is no such area.
  const WorldArea* findArea(int id) const;
};

/// Reads a map file with all its layers as of its last commit. Throws Error as readMap() does.
WorldMap readWorld(const std::filesystem::path& path);

}  // namespace estancia
