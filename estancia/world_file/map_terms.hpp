// Map terms: the options and the camera that a map is made with; it goes on with the same. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "estancia/core/camera.hpp"
#include "estancia/map_file/store.hpp"
#include "estancia/world_file/world_options.hpp"

namespace estancia {

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
