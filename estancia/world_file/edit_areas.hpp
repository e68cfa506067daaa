// Area edits: what the edits of areas by people are checked and found by. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "estancia/world_file/edit_map.hpp"

namespace estancia {

/// The area of that number; nullptr where the text is no number of an area.
const WorldArea* findAreaNumber(const WorldMap& world, std::string_view text);

/// Throws the Error (invalidInput) of a split that does not cut an area in two.
[[noreturn]] void failUncut(const AreaEdit& split);

/// Throws Error (invalidInput) for a name of more than 120 bytes, with control characters or of no UTF-8
/// (what printable() shows otherwise), of blanks, and for one that would be taken for a number; `what` it is
/// for: "an area". "" is none, and takes a name away.
void requireGivenName(const std::string& name, const char* what);

}  // namespace estancia
