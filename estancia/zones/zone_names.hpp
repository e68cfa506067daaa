// Zone names: what zones are called for people. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "estancia/zones/zones.hpp"

namespace estancia {

/// The room that a zone was taken for, and its telling words after it: "kitchen: stove, refrigerator"; the
/// words alone where it was taken for none.
inline std::string describedName(const Zone& zone) {
  return zone.predicted.empty() ? zone.name : zone.predicted.front().room + ": " + zone.name;
}

/// Short name: "kitchen", else the first of its words.
inline std::string shortName(const Zone& zone) {
  return zone.predicted.empty() ? zone.name.substr(0, zone.name.find(',')) : zone.predicted.front().room;
}

}  // namespace estancia
