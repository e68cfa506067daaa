// Stream agreement: how far a stream's zones are from those that are found at once. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

#include "estancia/core/progress.hpp"
#include "estancia/stats/clustering_agreement.hpp"
#include "estancia/zones/zone_stream.hpp"

namespace estancia {

/// How far a stream's zones are from those that findZones() makes of the same images.
struct StreamAgreement {
  /// Number of compared images.
  std::size_t images = 0;
  /// Number of zones that findZones() makes of them.
  std::size_t zones = 0;
  /// Agreement of the two, with findZones() as the truth.
  Agreement agreement;
};

/// Compares `zoneOf`, the stream's zones of the sequence's frames, on all images or, where there are more
/// than `maxImages`, on this many spread evenly over the run. Throws as findZones() does.
StreamAgreement compareWithExact(const DescriptorSequence& sequence, std::span<const int> zoneOf,
                                 const ZoneOptions& options, std::size_t maxImages = 5000,
                                 Progress& progress = Progress::none());

}  // namespace estancia
