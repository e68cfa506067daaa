// Map source: what a map file keeps of its drives, read to make another map of it. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <opencv2/core/affine.hpp>
#include <optional>
#include <vector>

#include "estancia/map_file/map.hpp"
#include "estancia/map_file/store.hpp"
#include "estancia/mapper/mapper.hpp"
#include "estancia/world_file/observation.hpp"
#include "estancia/world_file/world_store.hpp"

namespace estancia {

/// Snapshot of a map. Frames are identified by their position in map.frames.
struct MapSource {
  /// Throws Error as readMap(); insufficientData for a map without frames, corruptFile without places.
  explicit MapSource(const std::filesystem::path& file);

  std::optional<Pose> givenPose(std::size_t frame) const { return store.givenPose(map.frames[frame].number); }
  LexicalDescriptor descriptor(std::size_t frame) const { return store.descriptor(map.frames[frame].number); }
  std::vector<unsigned char> image(std::size_t frame) const { return store.image(map.frames[frame].number); }
  std::optional<Observation> observation(std::size_t frame) const;
  std::vector<std::size_t> numbers(std::size_t first, std::size_t end) const;
  /// T_map_drive of a drive that is aligned.
  cv::Affine3d alignment(std::size_t drive) const;
  std::size_t end(std::size_t drive) const;
  /// Whether a frame has a pose in the map.
  bool hasPoses() const;

  std::filesystem::path path;
  mutable MapStore store;  ///< reading its tables needs the connection
  TopologicalMap map;
  std::optional<WorldStore> layers;
  std::vector<bool> isObserved;
};

/// Throws Error: mismatch for other vocabularies, models or distances, invalidInput for a drive in common.
void requireMergeable(const MapSource& first, const MapSource& other);

}  // namespace estancia
