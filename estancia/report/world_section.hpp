// World section: the parts of a map's page that show areas and objects: the floor plan, what its script
// needs, a list. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "estancia/figures/driven_path.hpp"
#include "estancia/figures/plan_shapes.hpp"
#include "estancia/report/world_view.hpp"

namespace estancia::report {

/// A <section> "world": the page's search form, the floor plan for wide and narrow windows, and the panel
/// that world_page.js fills.
Markup worldSection(const WorldView& view, const Markup& searchForm);

/// An <svg> in which every object is a link to `#object-<id>` and carries its number as data-object: a small
/// image (imageSymbols()) where there is room, else a dot. Areas link to `#area-<id>`. Its attribute data-fit
/// gives the transform from meters to pixels ("scale from-x from-y to-x to-y"; y of the floor grows upwards),
/// and has an empty <g class="way"> for the script. `shapes`: empty for a map without a plan.
Markup worldFigure(const WorldView& view, const PlanShapes& shapes, FigureStyle style);

/// A word that finds an object, for the search form; "" where none has words.
std::string exampleWord(const WorldMap& world);

/// Data of world_page.js: {"from": node, "objects": [{"name", "given", "words": [[label, p]], "probability",
/// "where"}], "areas": [{"id", "name", "given", "room"}]}; label is an index of the vocabulary, p in
/// 1/10,000; "room": WorldArea::roomName. Objects and areas that can be driven to have "cost" (Route::cost),
/// and, where it was driven, "length" and "way" [[x, y]]; objects also "pose" [x, y, yaw], "distance" and
/// "frame" [m, rad].
nlohmann::json worldData(const WorldView& view);

/// A <section> "areas": areas as articles with the id area-<id>, objects as links with the id object-<id>,
/// the most probable first; what is in no area comes last. Empty for a map without areas and objects.
Markup worldList(const WorldView& view);

}  // namespace estancia::report
