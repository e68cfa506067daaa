// How two groupings of the same images meet: rooms and zones.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "estancia/report/html.hpp"
#include "estancia/report/zone_summary.hpp"

namespace estancia::report {

/// How many images of each room are in each zone.
struct RoomCounts {
  std::vector<std::string> rooms;                ///< rooms of the same main zone together, in order of zones
  std::vector<std::vector<std::size_t>> counts;  ///< a row a room, a column a zone
};

/// Images whose room is not known are left out; empty when none is. The last column stands for all zones from
/// `columns` on, where there are so many.
RoomCounts countRooms(const Zones& zones, std::size_t columns);

/// A <table>: rooms down, zones across, each cell shaded by its share of the room's images.
Markup roomTable(const ZonesSummary& summary, const RoomCounts& counts);

}  // namespace estancia::report
