// Map budget: how much memory and how large a file a map may take, whatever the robot drives.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "estancia/core/options.hpp"

namespace estancia {

/// In megabytes (10⁶ bytes); without a value, as much as it takes. A map keeps its budget.
struct MapBudget {
  /// Limit for the places, their views and the drive guide, in memory; without the labeling model.
  std::optional<std::uint64_t> memory;
  /// Limit for the map file.
  std::optional<std::uint64_t> file;

  bool operator==(const MapBudget&) const = default;
};
OptionGroup declare(MapBudget& budget);

/// Report of compactMap().
struct CompactedMap {
  std::uintmax_t bytesBefore = 0, bytesAfter = 0;
  std::size_t framesBefore = 0, framesAfter = 0;
};

/// Gives the file's unused space back and, where `fileBudget` [MB] is given, leaves out frames until it fits:
/// from the places with most frames, those that add the least information to the others. Places, objects,
/// areas, names and corrections stay. Throws Error as readMap() does, busy when another process writes the
/// map, and tooLarge when what must stay does not fit.
CompactedMap compactMap(const std::filesystem::path& map, const std::optional<std::uint64_t>& fileBudget);

}  // namespace estancia
