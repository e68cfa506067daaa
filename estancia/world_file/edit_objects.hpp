// Object edits: the objects that edits by people are about, and how these are done. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "estancia/world_file/edit_map.hpp"

namespace estancia {

/// The object that an edit is about: of about its size, and the nearest within half its length, or 0.2 m; -1
/// where there is none.
int objectOf(const ObjectEdit& edit, std::span<const WorldObject> objects);

/// Does the edits, in order. Removed objects leave no gaps. Returns the new number of each object, -1 for
/// those that were removed.
std::vector<int> applyEdits(std::span<const ObjectEdit> edits, std::vector<WorldObject>& objects);

}  // namespace estancia
