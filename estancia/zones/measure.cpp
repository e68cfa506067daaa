// SPDX-License-Identifier: Apache-2.0
#include "estancia/zones/measure.hpp"

#include <map>

namespace estancia {

ZoneQuality evaluate(const Zones& zones) {
  ZoneQuality quality{zones.zones.size(), zones.frames.size(), 0, {}, {}, {}};
  std::map<std::string, int> numbers;
  std::vector<int> rooms, clusters;
  for (std::size_t i = 0; i < zones.frames.size(); ++i) {
    const std::string& room = zones.frames[i].room;
    if (room.empty()) continue;
    rooms.push_back(numbers.emplace(room, static_cast<int>(numbers.size())).first->second);
    clusters.push_back(zones.zoneOf[i]);
  }
  quality.framesWithRoom = rooms.size();
  if (!rooms.empty()) quality.rooms = measureAgreement(rooms, clusters);
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
