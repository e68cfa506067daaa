// Zone quality: agreement with known rooms, predicted rooms, spatial spread. Private.
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
  /// Zones against the rooms that the frames see instead of those that the camera stood in; absent when these
  /// were not given.
  std::size_t framesWithRoomSeen = 0;
  std::optional<Agreement> roomsSeen = {};
};

/// `roomsSeen` holds the room that each frame sees, "" where unknown; empty where none is known. Throws Error
/// (mismatch) when it has not one a frame.
ZoneQuality evaluate(const Zones& zones, std::span<const std::string> roomsSeen = {});

}  // namespace estancia
