// Map edits: how people's corrections are read, and done to a map file at rest.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "estancia/live/live_view.hpp"

namespace estancia {

/// A correction as people send it: {"type": "name_area", "area", "name"}, {"type": "merge_areas", "area",
/// "other"}, {"type": "split_area", "from": [x, y], "to": [x, y]}, {"type": "name_object", "object", "name"},
/// {"type": "delete_object", "object"}. Throws Error (invalidInput) for anything else, and for names that
/// are longer than 120 bytes or have control characters.
MapEdit parseEdit(const std::string& json);

/// Does it to a map file that nobody else writes. Throws Error as the functions of edit_areas.hpp and
/// edit_objects.hpp do.
void editMapFile(const std::filesystem::path& path, const MapEdit& edit);

}  // namespace estancia
