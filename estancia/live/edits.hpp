// Map edits: how people's corrections are read, and done to a map file at rest.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estancia/live/live_view.hpp"

namespace estancia {

/// A correction as people send it: {"type": "name_area", "area", "name"}, {"type": "merge_areas", "area",
/// "other"}, {"type": "split_area", "from": [x, y], "to": [x, y]}, {"type": "name_object", "object", "name"},
/// {"type": "delete_object", "object"}. Throws Error (invalidInput) for anything else, and for names that
/// are longer than 120 bytes or have control characters.
MapEdit parseEdit(const std::string& json);

/// Throws Error (mismatch) where a correction is of another revision of the map than it is at `now`.
void requireRevision(const std::optional<std::uint64_t>& mapRevision, std::uint64_t now);

/// Applies the edit to a map file that no other process writes. Throws Error as the functions of
/// edit_map.hpp do.
void editMapFile(const std::filesystem::path& path, const MapEdit& edit);

}  // namespace estancia
