// World options: the layers of a map, and how a drive becomes areas and objects. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "estancia/areas/areas.hpp"
#include "estancia/core/options.hpp"
#include "estancia/objects/instance_map.hpp"
#include "estancia/odometry/rgbd.hpp"
#include "estancia/segmentation/clusters.hpp"

namespace estancia {

/// Layers of a map above its places, as far as the drive allows.
struct WorldLayers {
  bool zones = true, areas = true, objects = true;
  bool operator==(const WorldLayers&) const = default;
};
/// "places,zones,areas,objects", and back; places are always there. Throws Error (unknownName).
std::string toString(const WorldLayers& layers);
WorldLayers layersFrom(const std::string& names);

struct WorldOptions {
  /// Absent: those of the map that is continued, else all.
  std::optional<WorldLayers> layers;
  double viewShift = 0.05;
  double viewTurn = 3;
  std::size_t crops = 1;
  AreaOptions areas;
  ClusterOptions segments;
  InstanceMapOptions objects;
  RgbdOptions odometry;
};
OptionGroup declare(WorldOptions& options);

/// Options that are wanted of a map; without, those that it has.
struct WantedWorld {
  WantedWorld() = default;
  WantedWorld(const WorldOptions& wanted) : options(wanted) {}
  WantedWorld(const std::optional<WorldOptions>& wanted) : options(wanted) {}
  std::optional<WorldOptions> options;
};

}  // namespace estancia
