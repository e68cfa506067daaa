// The zone file, FILE.zones: a run and its zones as JSON, for this program and others.
#pragma once

#include <filesystem>
#include <string>

#include "estancia/zones/zones.hpp"

namespace estancia {

/// The file's text: {"format": "estancia-zones", "version": 1, "vocabulary": {"digest", "labels", "parts"},
/// "model", "distance", "linkage", "cut", "cut_reason", "zones": […], "rooms": […], "frames": […],
/// "dendrogram": […]}; docs/how-to/zones.md lists every key. Probabilities have the fewest digits that read back as
/// the same float32; texts that are no UTF-8 are written as {"hex": …}. Zones with predicted rooms make a
/// file of version 2; others stay in version 1, which older programs read.
std::string zoneFileText(const Zones& zones);

/// Writes the file whole or not at all, replacing what was there. Throws Error.
void writeZoneFile(const Zones& zones, const std::filesystem::path& file);

/// Reads it back, equal in every value. Throws Error, each with its own sentence: no such file, no zone file,
/// of a newer version, damaged or cut short.
Zones readZoneFile(const std::filesystem::path& file);

/// Whether the file begins as a zone file does, sound or not: tells it from a map, whatever its name.
bool isZoneFile(const std::filesystem::path& file);

}  // namespace estancia
