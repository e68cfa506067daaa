// Localizer map: nodes and frames of a map as localization compares with them. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>

#include "estancia/core/descriptor.hpp"
#include "estancia/map_file/map.hpp"
#include "estancia/map_file/store.hpp"
#include "estancia/mapper/node_bank.hpp"

namespace estancia {

struct LocalizerMap {
  TopologicalMap map;
  NodeBank bank;
  /// The descriptors of frames 0, stride, 2·stride … of the map.
  DescriptorMatrix images;
  std::size_t stride = 1;
};

/// Reads one from a map file, with at most `maxImages` frames, evenly thinned. Throws Error as readMap().
LocalizerMap readLocalizerMap(const std::filesystem::path& path, std::size_t maxImages);
/// Reads from an open store.
LocalizerMap readLocalizerMap(const MapStore& store, std::size_t maxImages);
/// Reads the map with the nodes of a given mapper.
LocalizerMap readLocalizerMap(const MapStore& store, const NodeBank& bank, std::size_t maxImages);

}  // namespace estancia
