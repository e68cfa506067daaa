// Map region: a part of a map that a robot behaves differently in (thesis 5.6), by its name.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estancia/world_query/route_world.hpp"

namespace estancia {

/// Throws Error (unknownName) where nothing has that name.
RegionCosts regionCosts(const WorldMap& world, const RegionPreferences& preferences,
                        const RouteOptions& options, WordGraphSource source = nullptr);

}  // namespace estancia
