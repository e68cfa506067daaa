// Measures: quality measures as rows for people and keys for machines.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estancia/report/page_contents.hpp"

namespace estancia {

struct LocalizationAccuracy;
struct LocalizationSummary;
struct MapQuality;
struct WorldAccuracy;
struct ZoneQuality;

std::vector<Measure> measuresOf(const MapQuality& quality);
std::vector<Measure> measuresOf(const LocalizationSummary& summary);
std::vector<Measure> measuresOf(const LocalizationAccuracy& accuracy);
std::vector<Measure> measuresOf(const ZoneQuality& quality);
/// Only what was measured.
std::vector<Measure> measuresOf(const WorldAccuracy& accuracy);

}  // namespace estancia
