// Measures: quality measures as rows for people and keys for machines.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace estancia {

struct LocalizationAccuracy;
struct LocalizationSummary;
struct MapQuality;
struct WorldAccuracy;
struct ZoneQuality;

/// One row of a table of measures.
struct Measure {
  std::string key;   ///< in JSON
  std::string name;  ///< for people
  std::optional<double> value;
  int decimals;
  std::string explanation;   ///< one sentence
  std::string text() const;  ///< the value, or "unknown"
};

std::vector<Measure> measuresOf(const MapQuality& quality);
std::vector<Measure> measuresOf(const LocalizationSummary& summary);
std::vector<Measure> measuresOf(const LocalizationAccuracy& accuracy);
std::vector<Measure> measuresOf(const ZoneQuality& quality);
/// Only what was measured.
std::vector<Measure> measuresOf(const WorldAccuracy& accuracy);

}  // namespace estancia
