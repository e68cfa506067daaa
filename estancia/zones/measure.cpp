// SPDX-License-Identifier: Apache-2.0
#include "estancia/zones/measure.hpp"

#include <string>
#include <vector>

namespace estancia {

ZoneQuality evaluate(const Zones& zones, std::span<const std::string> roomsSeen) {
  ZoneQuality quality;
  quality.zones = zones.zones.size();
  quality.frames = zones.frames.size();
  std::vector<std::string> rooms;
  for (const Frame& frame : zones.frames) rooms.push_back(frame.room);
  const NamedAgreement known = measureNamedAgreement(rooms, zones.zoneOf);
  quality.framesWithRoom = known.items;
  quality.rooms = known.agreement;
  if (!roomsSeen.empty()) {
    const NamedAgreement seen = measureNamedAgreement(roomsSeen, zones.zoneOf);
    quality.framesWithRoomSeen = seen.items;
    quality.roomsSeen = seen.agreement;
  }
  std::size_t judged = 0, right = 0;
  for (std::size_t i = 0; i < zones.frames.size(); ++i) {
    const auto& predicted = zones.zones[static_cast<std::size_t>(zones.zoneOf[i])].predicted;
    if (zones.frames[i].room.empty() || predicted.empty()) continue;
    ++judged;
    if (predicted.front().room == zones.frames[i].room) ++right;
  }
  if (judged > 0) quality.predictedRoom = static_cast<double>(right) / static_cast<double>(judged);
  double sum = 0;
  std::size_t posed = 0;
  for (const Zone& zone : zones.zones) {
    if (!zone.extent) continue;
    sum += zone.extent->spread * static_cast<double>(zone.extent->images);
    posed += zone.extent->images;
  }
  if (posed > 0) quality.spatialSpread = sum / static_cast<double>(posed);
  return quality;
}

}  // namespace estancia
