// SPDX-License-Identifier: Apache-2.0
#include "estancia/zones/measure.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "estancia/core/fail.hpp"

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

StreamAgreement compareWithExact(const DescriptorSequence& sequence, std::span<const int> zoneOf,
                                 const ZoneOptions& options, std::size_t maxImages, Progress& progress) {
  const std::size_t frames = sequence.frames.size(), compared = std::min(frames, maxImages);
  if (zoneOf.size() != frames)
    fail(ErrorCode::mismatch, "{} zone numbers do not belong to {} frames; give one a frame", zoneOf.size(),
         frames);
  DescriptorSequence sample{
      sequence.vocabulary, sequence.model, {}, DescriptorMatrix(sequence.vocabulary.size())};
  std::vector<int> streamed;
  for (std::size_t i = 0; i < compared; ++i) {
    const std::size_t frame = i * frames / compared;
    sample.frames.push_back(sequence.frames[frame]);
    sample.descriptors.append(sequence.descriptors.row(frame));
    streamed.push_back(zoneOf[frame]);
  }
  ZoneOptions exactOptions = options;
  if (exactOptions.count) exactOptions.count = std::min(*exactOptions.count, compared);
  const Zones exact = findZones(sample, exactOptions, progress);
  return {compared, exact.zones.size(), measureAgreement(exact.zoneOf, streamed)};
}

}  // namespace estancia
