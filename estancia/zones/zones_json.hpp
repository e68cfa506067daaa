// Zones JSON: the output of `estancia zones find --json`, and labels of rooms for other programs. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "estancia/words/label_concepts.hpp"
#include "estancia/zones/zones.hpp"

namespace estancia {

/// {"model", "distance", "linkage", "cut", "cut_reason", "zones": [{"id", "name", "images", "share",
/// "words": [{"label", "word", "p", "lift"}], "room", "room_share", "predicted_rooms": [{"room", "p"}],
/// "position", "spread"}], "rooms": toRoomsJson()}; unknown rooms and positions are null. `words` most
/// distinctive labels a zone; "word" is what people call it there (familiarWords()).
nlohmann::ordered_json toJson(const Zones& zones, std::size_t words = 10, const LabelConcepts& concepts = {});

/// {"kitchen": {"images": 137, "words": {"refrigerator": 0.31, …}}, …}: each true room where rooms are known,
/// else, where a classifier has named zones, each predicted room with all zones that are taken for it
/// ("predicted": its mean probability over their images, "zones": their ids), else each zone by its name, in
/// order of Zones::rooms or Zones::zones; rooms by their names alone stand before the zones that are none
/// surely. With its `words` most distinctive labels (distinctiveLabels()), best first, with their mean
/// probability. A name that stands there twice gets its zone's number behind it.
std::string toRoomsJson(const Zones& zones, std::size_t words = 10);

}  // namespace estancia
