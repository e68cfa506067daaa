// Zones JSON: what `estancia zones find --json` says of zones. Private.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>

#include "estancia/zones/zones.hpp"

namespace estancia {

/// {"model", "distance", "linkage", "cut", "cut_reason", "zones": [{"id", "name", "images", "share",
/// "words": [{"label", "p", "lift"}], "room", "room_share", "predicted_rooms": [{"room", "p"}], "position",
/// "spread"}], "rooms": toRoomsJson()}; unknown rooms and positions are null. `words` most distinctive labels
/// a zone.
nlohmann::ordered_json toJson(const Zones& zones, std::size_t words = 10);

}  // namespace estancia
