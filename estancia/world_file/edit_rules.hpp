// Edit rules: what edits by people are checked by, and which area or object they are about. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "estancia/world_file/edit_map.hpp"

namespace estancia {

/// The number that the text is; -1 where it is none.
int numberIn(std::string_view text);

/// The area of that number; nullptr where the text is no number of an area.
const WorldArea* findAreaNumber(const WorldMap& world, std::string_view text);

/// Throws the Error (invalidInput) of a split that does not cut an area in two.
[[noreturn]] void failUncut(const AreaEdit& split);

/// Throws Error (invalidInput) for a name of more than 120 bytes, with control characters or of no UTF-8
/// (what printable() shows otherwise), of blanks, and for one that would be taken for a number; `what` it is
/// for: "an area". "" is none, and takes a name away.
void requireGivenName(const std::string& name, const char* what);

/// The object of an edit: of about its size, the nearest within half its length, or 0.2 m; -1 for none.
int objectOf(const ObjectEdit& edit, std::span<const WorldObject> objects);

/// Does the edits, in order, without gaps. Returns the new number of each object, -1 for removed ones.
std::vector<int> applyEdits(std::span<const ObjectEdit> edits, std::vector<WorldObject>& objects);

}  // namespace estancia
