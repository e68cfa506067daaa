// Zone file: FILE.zones, a run and its zones as JSON, for this program and others.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "estancia/zones/zones.hpp"

namespace estancia {

/// Reads a zone file, equal in every value to what was written. Throws Error: fileNotFound, unsupportedFile
/// (not a zone file, or another version), corruptFile (damaged or cut short).
Zones readZones(const std::filesystem::path& file);

/// Writes the file whole or not at all, replacing what was there. Throws Error (fileUnwritable).
void writeZones(const Zones& zones, const std::filesystem::path& file);

/// The file's text: {"format": "estancia-zones", "version": 3, "vocabulary": {"digest", "labels", "parts"},
/// "model", "settings": {"distance", "linkage", "cut", "cut_reason"}, "zones": […], "rooms": […],
/// "frames": […], "dendrogram": […]}; docs/how-to/zones.md lists every key. Probabilities have the fewest
/// digits that read back as the same float32; texts that are not UTF-8 are written as {"hex": …}.
std::string zoneFileText(const Zones& zones);

/// Whether the file begins as a zone file does, intact or not: distinguishes it from a map, whatever its
/// name.
bool isZoneFile(const std::filesystem::path& file);

}  // namespace estancia
