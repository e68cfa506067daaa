// Restoring a mapper: from the map file that it was made with. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "estancia/map_file/store.hpp"
#include "estancia/mapper/mapper.hpp"

namespace estancia {

// The states of a map file that a mapper is kept as.
inline constexpr const char* mapperStateKey = "mapper";
inline constexpr const char* mapperViewsKey = "views";
inline constexpr const char* mapperPriorKey = "label-prior";

/// The mapper that a map file was made with, as it was at the last commit.
Mapper restoreMapper(const MapStore& store);
/// `file` is its name in messages, of which the store may be a copy.
Mapper restoreMapper(const MapStore& store, const std::filesystem::path& file);

}  // namespace estancia
