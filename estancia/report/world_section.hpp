// World section: the part of a map's page that shows the floor plan, and what its script needs.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "estancia/figures/html.hpp"
#include "estancia/report/world_view.hpp"

namespace estancia::report {

/// A <section> "world": the page's search form, the floor plan for wide and narrow windows, and the panel
/// that world_page.js fills.
Markup worldSection(const WorldView& view, const Markup& searchForm);

/// A word that finds an object, for the search form; "" where none has words.
std::string exampleWord(const WorldMap& world);

/// Data of world_page.js: {"from": node, "objects": [{"name", "given", "words": [[label, p]], "probability",
/// "where"}], "areas": [{"id", "name", "given", "room"}]}; label is an index of the vocabulary, p in
/// 1/10,000; "room": WorldArea::roomName. Objects and areas that can be driven to have "cost" (Route::cost),
/// and, where it was driven, "length" and "way" [[x, y]]; objects also "pose" [x, y, yaw], "distance" and
/// "frame" [m, rad].
nlohmann::json worldData(const WorldView& view);

}  // namespace estancia::report
