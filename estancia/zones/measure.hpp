// Zone quality: agreement with known rooms and of streams with findZones(), spatial spread. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "estancia/stats/clustering_agreement.hpp"
#include "estancia/zones/zones.hpp"

namespace estancia {

/// Values that need rooms or poses are absent without them.
struct ZoneQuality {
  std::size_t zones = 0, frames = 0, framesWithRoom = 0;
  /// Zones as clusters of the frames whose room is known.
  std::optional<Agreement> rooms;
  /// Mean distance of posed frames to the center of their zone [m].
  std::optional<double> spatialSpread;
  /// Share of the frames with a known room whose zone is predicted to be in it; absent without a classifier.
  std::optional<double> predictedRoom = {};
  /// Zones against the rooms that the frames see instead of those that the camera stood in, if given.
  std::size_t framesWithRoomSeen = 0;
  std::optional<Agreement> roomsSeen = {};
};

/// `roomsSeen`: the room that each frame sees, "" where unknown; or empty. Throws Error (mismatch) otherwise.
ZoneQuality evaluate(const Zones& zones, std::span<const std::string> roomsSeen = {});

/// How far a stream's zones are from those that findZones() makes of the same images.
struct StreamAgreement {
  /// Numbers of compared images, and of zones that findZones() makes of them.
  std::size_t images = 0, zones = 0;
  /// Agreement of the two, with findZones() as the truth.
  Agreement agreement;
};

/// Compares `zoneOf`, the stream's zones of the sequence's frames, on all images or, where there are more
/// than `maxImages`, on this many spread evenly over the run. Throws as findZones() does.
StreamAgreement compareWithExact(const DescriptorSequence& sequence, std::span<const int> zoneOf,
                                 const ZoneOptions& options, std::size_t maxImages = 5000,
                                 Progress& progress = Progress::none());

}  // namespace estancia
