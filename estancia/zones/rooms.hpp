// Rooms JSON: the labels of each room, for other programs. Private.
#pragma once

#include <cstddef>
#include <string>

#include "estancia/zones/zones.hpp"

namespace estancia {

/// {"kitchen": {"images": 137, "words": {"refrigerator": 0.31, …}}, …}: each true room where rooms are known,
/// else, where a classifier has named zones, each predicted room with all zones that are taken for it
/// ("predicted": its mean probability over their images, "zones": their ids), else each zone by its name, in
/// order of Zones::rooms or Zones::zones; its `words` most distinctive labels (distinctiveLabels()), best
/// first, with their mean probability. A name that stands there twice gets its zone's number behind it.
std::string toRoomsJson(const Zones& zones, std::size_t words = 10);

}  // namespace estancia
