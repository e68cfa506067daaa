// World store: the tables of areas and objects in a map file. Private; see readWorld().
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <optional>

#include "estancia/topology/store.hpp"
#include "estancia/world/observation.hpp"
#include "estancia/world/world_map.hpp"

namespace estancia {

/// The layers above the places of a map. What is written belongs to the store's transaction.
class WorldStore {
 public:
  /// Makes the tables where they are missing and the map is written. The store must outlive it.
  WorldStore(MapStore& store, MapStore::Access access);

  /// Whether the map has tables of layers; only files of older programs have none.
  bool exists() const { return exists_; }

  // ---- writing
  void putObservation(std::size_t frame, const Observation& observation);
  /// Replaces all that is derived from observations.
  void putAreas(const PlannedFrames& planned);
  void addEdit(const AreaEdit& edit);

  // ---- reading
  std::size_t observationCount() const;
  /// In order of frames; stops early when `visit` returns false. Throws Error (corruptFile).
  void forEachObservation(const std::function<bool(std::size_t frame, const Observation&)>& visit) const;
  std::vector<AreaEdit> edits() const;
  /// Adds all layers to `world`, whose places have been read. Throws Error (corruptFile).
  void read(WorldMap& world) const;

 private:
  MapStore& store_;
  bool exists_ = true;
};

}  // namespace estancia
