// World options: how a drive becomes the layers of a map; a map goes on with its own. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "estancia/areas/areas.hpp"
#include "estancia/core/camera.hpp"
#include "estancia/core/options.hpp"
#include "estancia/map_file/store.hpp"
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

/// Other terms would make other layers of the same frames: they would depend on where a run had stopped.
class MapTerms {
 public:
  /// Terms of a map; empty for maps of older versions. The store must outlive it. Throws Error (corruptFile).
  explicit MapTerms(MapStore& store);

  /// The options that the map was made with, but layers (WorldStore::layers()) and threads.
  std::optional<WorldOptions> options() const;
  /// A sentence for each option that the map was made with and that has gone with another value since.
  std::vector<std::string> gone() const;
  /// Stores them, or compares: throws Error (mismatch) that names the differences.
  void keep(WorldOptions options);
  /// The camera of the last drive's depth images, and their units per meter as given; 0 if not given. Stores
  /// them, or compares: throws Error (mismatch) that names the difference.
  void keep(const CameraIntrinsics& camera, double depthScale);
  /// Keeps that of another map.
  void keepCameraOf(const MapTerms& other);
  /// Another drive may have another camera.
  void forgetCamera();

 private:
  void write();

  MapStore& store_;
  std::map<std::string, std::string> options_;  // by path
  std::string camera_, depthScale_;             // "" where none was kept
};

}  // namespace estancia
