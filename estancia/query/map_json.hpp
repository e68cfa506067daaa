// Map JSON: the output of `--json` of ask, route, localize and explain. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "estancia/localization/localizer.hpp"
#include "estancia/map_file/map.hpp"
#include "estancia/map_file/places.hpp"
#include "estancia/query/ask.hpp"
#include "estancia/query/route.hpp"

namespace estancia {

/// {"labels": […], "matches": [{"label", "probability", "reason"}], "corrected", "rooms": […]}; reason and
/// corrected are null where there is none.
nlohmann::ordered_json toJson(const Meaning& meaning, const Vocabulary& vocabulary);

/// {"words", what toJson() has of the meaning, "places": [{"node", "probability", "lift", "label", "rank",
/// "among_best_5", "room", "predicted_room", "room_probability"}]}; labels of answers that are rooms are
/// null.
nlohmann::ordered_json toJson(const std::string& words, const Answers& answers, const TopologicalMap& map,
                              const std::vector<Place>& places);

/// {"from", "to", "nodes": […], "cost", "unit"}.
nlohmann::ordered_json toJson(const Route& route);

/// {"from", "to", "nodes", "cost", "unit", "words", "label" or "room", "probability"}.
nlohmann::ordered_json toJson(const std::string& words, const WordRoute& found, const TopologicalMap& map);

/// {"image", "node", "nearest_image", "nearest_frame", "distance", "belief_node", "belief_image",
/// "belief_frame", "confidence", "unmapped"}: images by their names, frames by their numbers in the map;
/// unmapped is null where the map has no poses.
nlohmann::ordered_json toJson(const std::string& image, const Localization& answer,
                              const TopologicalMap& map);

/// {"frame", "number", "decision", "node", "node_now", "current", "to_current", "other", "to_other",
/// "tau_join", "tau_revisit", "sentences": explain()}; unmeasured distances are null. Throws as explain().
nlohmann::ordered_json explanationJson(const TopologicalMap& map, std::size_t frame);

}  // namespace estancia
