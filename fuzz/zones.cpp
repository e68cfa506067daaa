// SPDX-License-Identifier: Apache-2.0
#include "estancia/zones/zones.hpp"
#include "fuzz/fuzz_target.hpp"

namespace estancia::fuzz {

FUZZ_TARGET(zones, zone_file) {
  zoneFileText(readZones(inputFile("input.json", bytes)));
}

}  // namespace estancia::fuzz
