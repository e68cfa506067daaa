// Changed objects: objects that depth shows to be gone or new since a frame. Private; see findChanges().
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estancia/world_file/world_store.hpp"
#include "estancia/world_query/changes.hpp"

namespace estancia {

/// Objects gone since `firstNow` and new ones; pairs of these, most alike first, are moved objects.
std::vector<ObjectChange> changedObjects(const WorldMap& world, const WorldStore& store,
                                         std::size_t firstNow);

}  // namespace estancia
