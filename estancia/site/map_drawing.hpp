// Map drawing: a map as shapes on the floor, for a page to draw.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "estancia/core/pose.hpp"
#include "estancia/world_file/world_map.hpp"

namespace estancia {

/// See LiveQueries::map(). `placeNames`: one a node, "" where none is known.
nlohmann::ordered_json drawMap(const WorldMap& world, const Floor& floor,
                               const std::vector<std::string>& placeNames);

}  // namespace estancia
