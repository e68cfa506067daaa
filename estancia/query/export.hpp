// Map export: GraphML, JSON and the route graph of Nav2.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "estancia/core/options.hpp"
#include "estancia/map_file/map.hpp"

namespace estancia {

struct ExportOptions {
  std::size_t maxWords = 10;
  std::string frame = "map";
  bool bidirectional = true;
};
/// Declares the options.
OptionGroup declare(ExportOptions& options);

/// The formats of exportMap():
///  * graphml: GraphML 1.0, nodes with words, room (the true one), predicted_room and room_probability (a
///    classifier's), x, y, z [m] and frames, directed edges with counts. What is not known is left out.
///  * json: places → words: {"format": "estancia-places", "version": 1, "vocabulary": digest, "model",
///    "distance", "places": [{"id", "words": [{"label", "p"}], "room", "position": [x, y, z], "frames",
///    "predicted_rooms": [{"room", "p"}]}], "transitions": [{"from", "to", "count"}]}. Unknown rooms and
///    positions are null; predicted rooms, best first, are there when a classifier was run.
///  * nav2: the GeoJSON that the route server of Nav2 (nav2_route, GeoJsonGraphFileLoader) reads: nodes as
///    points with metadata (class = true or predicted room or best label, labels, probabilities, frames),
///    edges as lines whose cost is their length [m].
Choices exportFormats();

/// Throws Error (unknownName) on an unknown format; for nav2 (insufficientData) when a node has no position
/// or there is no transition: Nav2 refuses such graphs.
std::string exportMap(const TopologicalMap& map, const std::string& format,
                      const ExportOptions& options = {});

/// Writes the file whole or not at all. Throws Error (fileUnwritable).
void exportMap(const TopologicalMap& map, const std::string& format, const std::filesystem::path& path,
               const ExportOptions& options = {});

}  // namespace estancia
