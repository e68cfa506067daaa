// Zones to draw in tests.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include "estancia/zones/zones.hpp"

namespace estancia::test {

struct SampleZonesOptions {
  std::size_t zones = 5, imagesPerZone = 8, labels = 30;
  bool poses = true, rooms = true, dendrogram = true;
  std::string marker = {};  ///< put into every text
};

/// A robot that drives a ring of zones twice; zone z is the only one to show label z, the first ones have an
/// image more than the last.
Zones sampleZones(const SampleZonesOptions& options = {});

}  // namespace estancia::test
