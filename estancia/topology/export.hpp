// Map export: GraphML, JSON and the route graph of Nav2.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "estancia/core/choice.hpp"
#include "estancia/core/options.hpp"
#include "estancia/topology/map.hpp"

namespace estancia {

struct ExportOptions {
  /// Largest number of labels for each place.
  std::size_t maxWords = 10;
  /// nav2: the coordinate frame of the poses, as the robot's TF tree names it.
  std::string frame = "map";
  /// nav2: an edge each way for every transition; false: only as it was driven.
  bool bidirectional = true;
};
OptionGroup declare(ExportOptions& options);

/// GraphML 1.0: nodes with words, room (the true one), predicted_room and room_probability (a classifier's),
/// x, y, z [m] and frames, directed edges with counts. What is not known is left out.
std::string toGraphml(const TopologicalMap& map, const ExportOptions& options = {});

/// Places → words: {"format": "estancia-places", "version": 1, "vocabulary": digest, "model", "distance",
/// "places": [{"id", "words": [{"label", "p"}], "room", "position": [x, y, z], "frames",
/// "predicted_rooms": [{"room", "p"}]}],
/// "transitions": [{"from", "to", "count"}]}. Unknown rooms and positions are null; predicted
/// rooms, best first, are there when a classifier was run.
std::string toPlacesJson(const TopologicalMap& map, const ExportOptions& options = {});

/// The GeoJSON that the route server of Nav2 (nav2_route, GeoJsonGraphFileLoader) reads: nodes as points with
/// metadata (class = true or predicted room or best label, labels, probabilities, frames), edges as lines
/// whose cost is their length [m]. Throws Error (insufficientData) when a node has no position or there is no
/// transition: Nav2 refuses such graphs.
std::string toNav2(const TopologicalMap& map, const ExportOptions& options = {});

/// The formats of exportMap().
Choices exportFormats();

/// Throws Error (unknownName) on an unknown format.
std::string exportMap(const TopologicalMap& map, const std::string& format,
                      const ExportOptions& options = {});

/// Writes the file whole or not at all. Throws Error (fileUnwritable).
void exportMap(const TopologicalMap& map, const std::string& format, const std::filesystem::path& path,
               const ExportOptions& options = {});

}  // namespace estancia
