// Map edits as JSON: how people's corrections are read.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "estancia/live/live_view.hpp"

namespace estancia {

/// A correction as people send it: {"type": "name_area", "area", "name"}, {"type": "merge_areas", "area",
/// "other"}, {"type": "split_area", "from": [x, y], "to": [x, y]}, {"type": "name_object", "object", "name"},
/// {"type": "delete_object", "object"}. Throws Error (invalidInput) for anything else, and for names that
/// are longer than 120 bytes or have control characters.
MapEdit parseEdit(const std::string& json);

}  // namespace estancia
